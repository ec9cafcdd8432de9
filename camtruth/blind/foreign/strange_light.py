"""What no catalogue has, while it is light: a ghost, and infrared that the filter leaks."""

from __future__ import annotations

import numpy as np

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

HOT_LAMPS = ("incandescent", "halogen", "tungsten")
"""Lamps that shine by heat: most of their light is infrared. Tubes and diodes have next to none."""

GHOST_SIZE = 0.6
"""A reflection between two faces of a lens is out of focus and smaller: here by this factor."""


def ghost(rate: Numbers, strength: float, about: About) -> Numbers:
    """A weak, smaller, upside-down picture of the scene on top of it, smeared by 5 x 5 pixels."""
    height, width = rate.shape[1:3]
    rows = height / 2 - (np.arange(height) - height / 2) / GHOST_SIZE
    columns = width / 2 - (np.arange(width) - width / 2) / GHOST_SIZE
    seen = ((rows >= 0) & (rows < height))[:, None] & ((columns >= 0) & (columns < width))[None]
    row = np.clip(rows.astype(int), 0, height - 1)
    column = np.clip(columns.astype(int), 0, width - 1)
    turned = rate[:, row][:, :, column] * seen[None, :, :, None]
    smeared = sum(np.roll(turned, (i, j), axis=(1, 2)) for i in range(-2, 3) for j in range(-2, 3))
    return np.asarray(rate + strength * np.asarray(smeared) / 25)


def infrared_leak(rate: Numbers, strength: float, about: About) -> Numbers:
    """All three filters are open in the infrared: a hot lamp adds the same to every colour."""
    if not any(hot in lamp for lamp in about.lamps for hot in HOT_LAMPS):
        return rate
    return np.asarray(rate + strength * rate.max(axis=-1, keepdims=True))


def _own(name: str, act: object, weakest: float, strongest: float) -> Outsider:
    return Outsider(
        name=name,
        source="none",
        answers=(),
        stage="optics",
        place="rate",
        weakest=weakest,
        strongest=strongest,
        act=act,  # type: ignore[arg-type]
    )


OUTSIDERS = (
    _own("ghost", ghost, 1e-4, 0.2),
    _own("infrared_leak", infrared_leak, 1e-3, 0.5),
)
