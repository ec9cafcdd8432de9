"""An effect from elsewhere: a function on plain arrays, and what the right answer about it is.

Arrays come as the camera has them at that place:

    rate        (F, H, W, 3)  photo-electrons per second under each colour filter
    electrons   (F, H, W)     charge in e-, after photon shot noise has drawn it
    mosaic      (F, H, W)     DN that are not rounded yet, one colour in a pixel
    image       (F, H, W, 3)  DN that are not rounded yet, three colours in a pixel
    codes       (F, H, W) or (F, H, W, 3)  DN, whole numbers
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[Any]
Place = Literal["rate", "electrons", "mosaic", "demosaic", "image", "codes"]

BEFORE_THE_FIRST = 1 << 20
"""Frames that run in have negative numbers; generators want none."""


@dataclass(frozen=True, kw_only=True)
class About:
    """What an effect may know of the shot and of the camera it is in.

    Attributes:
        shot: label of the shot.
        lamps: names of the lamps that are on; empty in the dark.
        exposure_s: integration time in s.
        frames: numbers of the frames.
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1).
        bits: of a pixel.
        black_dn: black level.
        seed, body_seed: of what is drawn anew in every frame, and of what is fixed.
    """

    shot: str
    lamps: tuple[str, ...]
    exposure_s: float
    frames: tuple[int, ...]
    cfa: str
    bits: int
    black_dn: float
    seed: int
    body_seed: int

    @property
    def top_dn(self) -> int:
        """The largest pixel value."""
        return int(2**self.bits - 1)

    def draws(self, name: str) -> list[np.random.Generator]:
        """Random numbers of an effect, one generator for each frame."""
        key = [self.seed, zlib.crc32(name.encode()), zlib.crc32(self.shot.encode())]
        return [np.random.default_rng([*key, f + BEFORE_THE_FIRST]) for f in self.frames]

    def fixed(self, name: str) -> np.random.Generator:
        """Random numbers of an effect that stay with the camera body."""
        return np.random.default_rng([self.body_seed, zlib.crc32(name.encode())])

    def sites(self, height: int, width: int) -> NDArray[np.intp]:
        """Which of R, G, B (0 to 2) each pixel of the mosaic sees: (H, W)."""
        phase = np.array(["RGB".index(c) for c in self.cfa], dtype=np.intp).reshape(2, 2)
        return np.tile(phase, (-(-height // 2), -(-width // 2)))[:height, :width]


@dataclass(frozen=True, kw_only=True)
class Outsider:
    """An effect from elsewhere.

    Attributes:
        name: what it is called in the seal.
        source: whose code it is, or "none" where it is in no catalogue.
        answers: names of the catalogue that are right; empty where only "unexplained" is.
        stage: where in the signal path it acts, as the catalogue names the stages.
        place: what it is given; "demosaic" is given the mosaic and returns an image.
        weakest, strongest: range of its strength.
        act: array, strength and what it may know to the array after the effect.
        choice: its strength is one of a few, the whole numbers of the range.
        order: among the effects of the same place, smaller first.
    """

    name: str
    source: str
    answers: tuple[str, ...]
    stage: str
    place: Place
    weakest: float
    strongest: float
    act: Callable[[Numbers, float, About], Numbers]
    choice: bool = False
    order: int = 50
