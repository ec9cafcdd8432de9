"""The library colour-demosaicing, read without its complaint about SciPy."""

from __future__ import annotations

import importlib
import warnings
from types import ModuleType


def colour_demosaicing() -> ModuleType:
    """The library."""
    with warnings.catch_warnings():
        # version 0.2.7 imports scipy.ndimage.filters, a name that SciPy is about to retire
        warnings.simplefilter("ignore", DeprecationWarning)
        return importlib.import_module("colour_demosaicing")
