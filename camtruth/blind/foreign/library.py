"""All effects from elsewhere by name, and whose code is not installed here."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Iterable

from camtruth.blind.foreign.outsider import Outsider

FOLDER = "camtruth.blind.foreign"
STRANGE = ("strange_light", "strange_charge", "strange_signal")
OTHERS = {
    "opencv": "others_opencv",
    "colour-demosaicing": "others_demosaic",
    "libjpeg": "others_pillow",
    "scikit-image": "others_scikit_image",
    "ffmpeg": "others_pyav",
    "pyxel": "others_pyxel",
    "galsim": "others_galsim",
}
"""Modules by whose code they call."""


@functools.cache
def outsiders() -> dict[str, Outsider]:
    """Every effect whose code is installed, by name."""
    modules = [*STRANGE, *(OTHERS[source] for source in OTHERS if source not in missing())]
    found: Iterable[Outsider] = (
        outsider
        for module in modules
        for outsider in importlib.import_module(f"{FOLDER}.{module}").OUTSIDERS
    )
    return {outsider.name: outsider for outsider in found}


@functools.cache
def missing() -> tuple[str, ...]:
    """Sources that cannot be imported here."""
    return tuple(source for source, module in OTHERS.items() if not _imports(module))


def _imports(module: str) -> bool:
    try:
        importlib.import_module(f"{FOLDER}.{module}")
    except Exception:
        # a library built for another NumPy fails in many ways; all mean that it cannot be used
        return False
    return True
