"""What a camera without colour filters sees of light that is stated in three colours.

A rate image has one rate for each filter and none for a sensor without any. The frames tell which
sum of the three it sees: green alone, as a grey camera of the simulator does, all that falls on it,
the luminance, or one of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Floats = NDArray[np.floating]

FAR_NEARER = 0.25
"""Part of what a sum leaves of the pictures that another one leaves, where it is what a camera
sees: an error of its spectral response is no usual sum, and leaves of none that little."""

NOTHING = 1e-7
"""Part of a picture's variance that is what rounding of its light leaves."""

MOSTLY_GREEN = 0.75
"""Part of green from which a sum of its own is green with an error of its spectral response."""


@dataclass(frozen=True, kw_only=True)
class Sum:
    """A sum of colours.

    Attributes:
        name: for those who read where the light is from.
        weights: of red, green and blue.
    """

    name: str
    weights: tuple[float, float, float]


GREEN = Sum(name="green", weights=(0.0, 1.0, 0.0))
USUAL = (
    GREEN,
    Sum(name="red, green and blue together", weights=(1.0, 1.0, 1.0)),
    Sum(name="luminance", weights=(0.299, 0.587, 0.114)),
)
"""Reference of the last: ITU-R Recommendation BT.601."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A picture of one lamp.

    Attributes:
        seen: above black, where it is clear, (n,).
        rate: the light that is stated there, (n, 3).
    """

    seen: Floats
    rate: Floats


def sum_seen(pictures: Sequence[Picture]) -> Sum:
    """The sum of colours that a grey camera sees.

    Args:
        pictures: of each lamp.
    """

    def left(weights: Sequence[float] | Floats) -> float:
        return sum(_left(one, weights) for one in pictures)

    nearest = min(USUAL, key=lambda usual: left(usual.weights))
    if left(nearest.weights) >= FAR_NEARER * left(GREEN.weights):
        nearest = GREEN
    if left(nearest.weights) < NOTHING:
        return nearest
    found = minimize(left, np.full(3, 1 / 3), bounds=[(0.0, 1.0)] * 3).x
    red, green, blue = map(float, found / max(found.sum(), 1e-9))
    farther = left((red, green, blue)) >= FAR_NEARER * left(nearest.weights)
    if farther or green >= MOSTLY_GREEN:
        return nearest
    name = f"{red:.2f} of red, {green:.2f} of green and {blue:.2f} of blue"
    return Sum(name=name, weights=(red, green, blue))


def _left(picture: Picture, weights: Sequence[float] | Floats) -> float:
    """Part of a picture's variance that its light, as bright as fits, leaves."""
    off = picture.seen - picture.seen.mean()
    expected = picture.rate @ np.asarray(weights)
    expected = expected - expected.mean()
    power = float(expected @ expected)
    if power == 0.0 or not off.any():
        return 1.0
    left = off - expected * float(off @ expected) / power
    return float(left @ left) / float(off @ off)


def in_green(rate: Floats, weights: Sequence[float]) -> NDArray[np.float32]:
    """A rate image (H, W, 3) whose green is that sum."""
    made = np.array(rate, dtype=np.float32)
    made[..., 1] = rate @ np.asarray(weights, dtype=np.float32)
    return made
