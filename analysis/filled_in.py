"""Whether colours were filled in, or every pixel was measured in all of them, as by three sensors.

What is filled in is a mean of neighbours, so that a sample has noise in common with those next to
it: red behind a Bayer mosaic and bilinear interpolation 0.5 with its neighbour along the row. What
was measured has none in common, whatever it is worth. How loud samples are does not tell the two
apart: what is smoothed afterwards is as loud everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensor.frames import Frames

BORDER_PX = 8
"""Pixels along the border that are not looked at: what lies beyond it is anybody's guess."""

PAIRS = 4
"""Pairs of frames of a shot whose differences are looked at."""

IN_COMMON = 0.1
"""Correlation of a sample with one of its neighbours up to which neither is made of the other: of
20,000 pixels that are measured it has an error of 0.007. Noise of rows or columns makes it larger
along them alone, light that wanders in lit shots alone; so the least of all shots and ways counts.
"""

LEAST_NOISE_DN2 = 0.02
"""Variance in DN^2 of a difference of two frames that is noise: less are single pixels that came
another way."""

WAYS = ((0, 1), (1, 0), (1, 1))
"""Down and to the right, to the neighbours that are looked at."""


def filled_in(shots: Sequence[Frames]) -> bool:
    """Whether colours were filled in: of frames of three colours without a stated mosaic they were,
    unless red and blue, which a mosaic has at every fourth pixel, have no noise in common with
    their neighbours.

    Args:
        shots: of one camera.
    """
    first = shots[0]
    if not first.demosaiced or first.cfa is not None:
        return first.demosaiced
    least = np.min([_in_common(one.dn) for one in shots], axis=0)
    return not bool((least < IN_COMMON).all())


def _in_common(stack: NDArray[Any]) -> NDArray[np.float64]:
    """Least correlation with a neighbour, of red and of blue; 1 where there is no noise."""
    inside = slice(BORDER_PX, -BORDER_PX)
    frames = stack[: 2 * PAIRS, inside, inside, ::2].astype(np.float32)
    pairs = len(frames) // 2
    if pairs == 0 or min(frames.shape[1:3]) < 2:
        return np.ones(2)
    noise = frames[: 2 * pairs : 2] - frames[1 : 2 * pairs : 2]
    noise = noise - noise.mean(axis=(1, 2), keepdims=True)
    power = np.square(noise).mean(axis=(0, 1, 2), dtype=np.float64)
    if (power < LEAST_NOISE_DN2).any():
        return np.ones(2)
    _, height, width, _ = noise.shape
    found = []
    for dy, dx in WAYS:
        here, there = noise[:, : height - dy, : width - dx], noise[:, dy:, dx:]
        found.append((here * there).mean(axis=(0, 1, 2), dtype=np.float64) / power)
    return np.asarray(np.min(np.abs(found), axis=0))
