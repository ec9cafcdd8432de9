"""Optional libraries: there, or one line that says what to install."""

from __future__ import annotations

import importlib
from typing import Any

from camtruth.exchange.errors import MissingLibraryError


def library(module: str, purpose: str) -> Any:
    """An optional library, imported.

    Args:
        module: what Python calls it, which is what pip calls it for all that are used here.
        purpose: what it is needed for, as in "to write Zarr".

    Raises:
        MissingLibraryError: when it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        raise MissingLibraryError(
            f"no library '{package}' {purpose}",
            "expected the extra 'exchange' of camtruth",
            f"pip install 'camtruth[exchange]', or pip install {package}",
        ) from None
