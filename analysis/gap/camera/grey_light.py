"""What a camera without colour filters sees of light that is stated in three colours.

A rate image has one rate for each filter and none for a sensor without any. The frames tell which
sum of the three it sees: green alone, as a grey camera of the simulator does, all that falls on it,
or the luminance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating]

GREEN = (0.0, 1.0, 0.0)
SUMS = {
    "green": GREEN,
    "red, green and blue together": (1.0, 1.0, 1.0),
    "luminance": (0.299, 0.587, 0.114),
}
"""Of red, green and blue. Reference of the last: ITU-R Recommendation BT.601."""

FAR_NEARER = 0.25
"""Part of what green leaves of the pictures that another sum leaves, where it is what a camera
sees: an error of its spectral response is no such sum, and leaves of neither that little."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A picture of one lamp.

    Attributes:
        seen: above black, where it is clear, (n,).
        rate: the light that is stated there, (n, 3).
    """

    seen: Floats
    rate: Floats


def sum_seen(pictures: Sequence[Picture]) -> str:
    """Name of the sum of colours that a grey camera sees.

    Args:
        pictures: of each lamp.
    """
    left = {name: sum(_left(one, weights) for one in pictures) for name, weights in SUMS.items()}
    nearest = min(left, key=lambda name: left[name])
    return nearest if left[nearest] < FAR_NEARER * left["green"] else "green"


def _left(picture: Picture, weights: Sequence[float]) -> float:
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
