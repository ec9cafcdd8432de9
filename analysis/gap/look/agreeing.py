"""How the noise of measured samples agrees with that of those beside them.

A demosaicer that passes what was measured leaves its noise independent. One by normalised
convolution does so with red and blue, whose next samples are two pixels away, and makes of a
measured green one

    g' = (g + (g1 + g2 + g3 + g4) / 4) / 2

with those at its corners: noise of variance 1 becomes 1/4 + 4/64 = 5/16, with a covariance of
2 (1/2) (1/8) = 1/8 with each of them, a correlation of two fifths.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.lattices import Lattice, of_a_mosaic
from analysis.gap.look.shots import HINT_FRAMES
from analysis.gap.look.statistics.group import lagged
from sensor.frames import Frames

Floats = NDArray[np.float64]

LEAST_CORRELATION = 0.02
"""Of a sample with the next one, from which a filter is told: charge that spreads makes less."""

WANDERS = 0.05
"""Part of the power of noise that both halves of a picture share, from which whole frames wander. A
filter leaves them a few thousandths, by chance."""

OF_CORNERS = 2 / 5
"""Correlation of the noise of a green that is averaged with that of each green at its corners."""

WITHIN = 0.05
"""Of that correlation, in lit frames of every level: that it comes out so without such a demosaicer
is no chance, as samples that pass unchanged have none."""


def correlations(stack: Frames, lattices: Sequence[Lattice]) -> Floats:
    """Of noise with the next sample of its row, of its column, and the diagonal one: (3,)."""
    return _products(stack, lattices, lambda width: (1, width, width + 1))


def beyond_the_next(stack: Frames, lattices: Sequence[Lattice]) -> float:
    """Of noise with the sample after the next one, in the mean of its row and its column."""
    return float(_products(stack, lattices, lambda width: (2, 2 * width)).mean())


def _products(
    stack: Frames, lattices: Sequence[Lattice], lags: Callable[[int], tuple[int, ...]]
) -> Floats:
    """Of noise with itself so many samples further on, of those of a line's width, over its power
    without that of rounding. What whole frames do is none of it, where both halves of a picture
    tell it: to take the mean of a frame off would take some of what neighbours share.
    """
    alone = [one for one in lattices if stack.dn.ndim == 3 or one.channel != "G"]
    rows = []
    for lattice in alone:
        values = lattice.of(np.asarray(stack.dn[:HINT_FRAMES])).astype(np.float32)
        noise = values - values.mean(axis=0)
        left, right = (half.mean(axis=(1, 2)) for half in np.array_split(noise, 2, axis=2))
        if float((left * right).mean()) > WANDERS * float(np.square(noise).mean()):
            noise -= noise.mean(axis=(1, 2), keepdims=True)
        rows.append([lagged(noise.ravel(), lag) for lag in (0, *lags(noise.shape[2]))])
    power, *products = np.sum(rows, axis=0)
    return np.asarray(products) / max(float(power) - len(alone) * ROUNDING_DN2, 1e-9)


def green_is_averaged(stacks: Sequence[Frames], lattices: Sequence[Lattice]) -> bool:
    """Whether greens agree with those at their corners by two fifths, and red and blue do not agree
    along both directions, which a filter makes them do. Noise of rows makes them do so along one.

    Args:
        stacks: frames of colours.
        lattices: where their measured samples are.
    """
    lit = [stack for stack in stacks if not stack.shot.dark]
    if not lit or stacks[0].pixels != "rgb8" or not of_a_mosaic(lattices):
        return False
    greens = np.array([of_corners(stack, lattices) for stack in lit])
    if np.abs(greens - OF_CORNERS).max() > WITHIN:
        return False
    others = np.mean([correlations(stack, lattices)[:2] for stack in lit], axis=0)
    return bool(others.min() < LEAST_CORRELATION)


def of_corners(stack: Frames, lattices: Sequence[Lattice]) -> float:
    """Of the noise of a measured green with that of the one at its corner, in one direction."""
    one, other = (
        values - values.mean(axis=0)
        for values in (
            lattice.of(np.asarray(stack.dn[:HINT_FRAMES])).astype(np.float32)
            for lattice in lattices
            if lattice.channel == "G"
        )
    )
    power = (float(np.square(one).mean()) + float(np.square(other).mean())) / 2
    return float((one * other).mean()) / max(power - ROUNDING_DN2, 1e-9)
