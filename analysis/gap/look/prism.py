"""Whether every pixel of a colour image was measured in all its colours, as by three sensors.

What is filled in is a mean of neighbours, so that a sample has noise in common with those next to
it: red behind a Bayer mosaic and bilinear interpolation 0.5 with its neighbour along the row. What
was measured has none in common, whatever it is worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import inner

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


def each_is_measured(stacks: Sequence[NDArray[Any]]) -> bool:
    """Whether red and blue, which a mosaic has at every fourth pixel, have no noise in common with
    their neighbours.

    Args:
        stacks: colour frames of some shots, each (n, H, W, 3).
    """
    least = np.min([_in_common(stack) for stack in stacks], axis=0)
    return bool((least < IN_COMMON).all())


def _in_common(stack: NDArray[Any]) -> NDArray[np.float64]:
    """Least correlation with a neighbour, of red and of blue; 1 where there is no noise."""
    frames = inner(stack[: 2 * PAIRS])[..., [0, 2]].astype(np.float32)
    pairs = len(frames) // 2
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
