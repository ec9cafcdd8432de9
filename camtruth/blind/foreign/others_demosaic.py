"""The demosaicers of colour-demosaicing: Malvar 2004 and Menon 2007."""

from __future__ import annotations

import warnings

import numpy as np

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

with warnings.catch_warnings():
    # version 0.2.7 imports a name that SciPy is about to retire
    warnings.simplefilter("ignore", DeprecationWarning)
    import colour_demosaicing

SOURCE = "colour-demosaicing"
BORDER = 6


def _filled(mosaic: Numbers, cfa: str, way: str) -> Numbers:
    fill = getattr(colour_demosaicing, f"demosaicing_CFA_Bayer_{way}")
    wide = np.pad(mosaic, ((0, 0), (BORDER, BORDER), (BORDER, BORDER)), mode="reflect")
    inner = slice(BORDER, -BORDER)
    return np.stack([np.asarray(fill(f, cfa))[inner, inner] for f in wide]).astype(np.float32)


def malvar(mosaic: Numbers, strength: float, about: About) -> Numbers:
    """Linear filling with the gradient of the colour that is known."""
    return _filled(mosaic, about.cfa, "Malvar2004")


def menon(mosaic: Numbers, strength: float, about: About) -> Numbers:
    """Filling along the direction in which the picture changes least."""
    return _filled(mosaic, about.cfa, "Menon2007")


OUTSIDERS = tuple(
    Outsider(
        name=f"colour-demosaicing {name}",
        source=SOURCE,
        answers=("demosaic_other",),
        stage="processing",
        place="demosaic",
        weakest=1,
        strongest=1,
        act=act,
        choice=True,
    )
    for name, act in (("malvar", malvar), ("menon", menon))
)
