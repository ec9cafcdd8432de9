"""The body of a camera by somebody else: how large it is, and what is drawn of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Numbers = NDArray[Any]

WIDTH, HEIGHT = 160, 120
GREY = "GGGG"
"""Filters of a camera that has none: all photosites are as green ones are elsewhere."""

SITES = ((0, 0), (0, 1), (1, 0), (1, 1))
Y, X = np.mgrid[:HEIGHT, :WIDTH].astype(float)
MIDDLE = ((HEIGHT - 1) / 2, (WIDTH - 1) / 2)


@dataclass(kw_only=True)
class Camera:
    """One body, and what it remembers from frame to frame of a shot.

    Figures are drawn about those of a consumer camera of 2005. `k` is how strong its fault is; a
    code of more than 8 bits is a part of one of 8.
    """

    k: float
    draw: np.random.Generator
    cfa: str = "RGGB"
    bits: int = 8
    frames: int = 40
    gain_dn_per_e: Numbers = field(init=False)
    black_dn: float = field(init=False)
    read_e: float = field(init=False)
    offset_e: Numbers = field(init=False)
    response: Numbers = field(init=False)
    dark_e_per_s: float = field(init=False)
    columns: Numbers = field(init=False)
    waves: Numbers = field(init=False)
    chance: Numbers = field(init=False)
    other_chance: Numbers = field(init=False)
    memory: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        draw, shape = self.draw, (HEIGHT, WIDTH)
        by_colour = np.array([0.055, 0.050, 0.060]) * draw.uniform(0.85, 1.15)
        self.gain_dn_per_e = np.empty(shape)
        for (y, x), colour in zip(SITES, self.cfa, strict=True):
            self.gain_dn_per_e[y::2, x::2] = by_colour["RGB".index(colour)]
        self.black_dn, self.read_e = draw.uniform(2.5, 5), draw.uniform(8, 18)
        self.gain_dn_per_e *= self.finer
        self.black_dn *= self.finer
        self.offset_e = draw.normal(0, draw.uniform(3, 8), shape)
        self.response = 1 + draw.normal(0, draw.uniform(0.006, 0.012), shape)
        self.dark_e_per_s = draw.uniform(800, 4000)
        self.columns = draw.normal(0, 1, WIDTH)
        self.waves = ndimage.gaussian_filter(draw.normal(size=shape), 12, mode="wrap")
        self.waves /= self.waves.std()
        self.chance, self.other_chance = draw.uniform(size=(2, *shape))

    @property
    def finer(self) -> int:
        """Codes in one of 8 bits."""
        return int(2 ** (self.bits - 8))

    @property
    def top(self) -> int:
        """The largest code."""
        return int(2**self.bits - 1)

    @property
    def period(self) -> int:
        """Photosites from one to the next behind the same filter."""
        return 1 if self.cfa == GREY else 2


def mosaic(rgb: Numbers, cfa: str) -> Numbers:
    """What falls on the photosites behind their filters."""
    behind = np.empty(rgb.shape[:2])
    for (y, x), colour in zip(SITES, cfa, strict=True):
        behind[y::2, x::2] = rgb[y::2, x::2, "RGB".index(colour)]
    return behind
