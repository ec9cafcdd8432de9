"""Pixels that are louder in time than noise makes any: how many, how loud, and in what way.

Traps stay where they are, so that a pixel counts by the frames of all dark shots. Its figures are

    ln(variance / variance of the typical pixel)       how loud
    1 between the quartiles of that in the frames      whether all are about as loud
    mean of x(t) x(t + k) / variance                   how much of it stays after k frames
    mean of x(t)^3 / variance^1.5                      whether it is more often down than up
    1 below the lower one                              whether few are much less loud than others
    part of the sum of x^2 in the longest exposure     whether exposure makes it louder

of its own frames x about their mean in each shot, in units of the typical pixel of that shot.
Means, threshold and rounding to codes bend all of them; whoever holds simulated pixels against them
has to look at those by this code.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice
from sensor.frame_times import interval_of
from sensor.frames import Frames
from sensor.thermal import darkness_s

Floats = NDArray[np.float64]
Stack = NDArray[np.float32]

MOST_FRAMES = 64
"""Of a shot."""

LOUD = 5.0
"""Standard errors of a variance in time by which it exceeds the typical one, if noise is normal."""

LAGS = (1, 2, 4, 8)
"""Frames after which a pixel is held against itself."""

FIGURES = 6 + len(LAGS)
HOW_LOUD, AFTER_ONE_FRAME = 1, 3
"""How many figures there are, and which of them are how loud, and what stays after one frame."""

ALL = -np.inf, np.inf

BETWEEN_CODES_DN2 = 0.25
"""Variance of a pixel that shows either of two codes in turn: less is the rounding of a level."""

RESAMPLED = 400
"""Times that pixels are drawn anew for the covariance of their figures."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """The samples of one lattice, in all shots.

    Attributes:
        samples: how many.
        gain_dn_per_e: of its channel.
        intervals_s: from frame to frame, of each shot.
        darkness_s: exposure of each shot at 29 degC in which as much dark current gathers.
        variances_dn2: in time, of the typical sample of each shot.
        levels_dn: mean of each sample over the frames of each shot, (shots, samples).
        frames: of each shot.
    """

    samples: int
    gain_dn_per_e: float
    intervals_s: tuple[float, ...]
    darkness_s: tuple[float, ...]
    variances_dn2: tuple[float, ...]
    levels_dn: Floats
    frames: tuple[int, ...]

    @property
    def threshold(self) -> float:
        """Variance in time, in that of the typical sample, from which a sample is loud."""
        freedom = sum(self.frames) - len(self.frames)
        return 1.0 + LOUD * float(np.sqrt(2.0 / freedom))


@dataclass(frozen=True, kw_only=True, eq=False)
class Loud:
    """The loud pixels of a body in the dark.

    Attributes:
        grounds: of every lattice.
        by_pixel: figures of each loud pixel, (FIGURES, pixels); the first one is 1, and of a single
            shot there is no last one.
        quartiles: of how loud they are.
    """

    grounds: tuple[Ground, ...]
    by_pixel: Floats
    quartiles: tuple[float, float]

    @property
    def pixels(self) -> int:
        """How many are loud."""
        return len(self.by_pixel[0])

    @property
    def samples(self) -> int:
        """Of how many."""
        return sum(ground.samples for ground in self.grounds)

    @property
    def seen(self) -> Floats:
        """The figures; see `summary`."""
        return summary(self.by_pixel.sum(axis=1), self.samples)

    @property
    def covariance(self) -> Floats:
        """Of the figures: who is loud is chance."""
        drawn = np.random.default_rng(0).poisson(1.0, (RESAMPLED, self.pixels))
        again = [summary(self.by_pixel @ times, self.samples) for times in drawn]
        return np.cov(np.transpose(again))


def summary(total: Floats, samples: float) -> Floats:
    """Figures of loud pixels by their sum: ln(their share), and the means of the others."""
    number = max(float(total[0]), 0.5)
    return np.array([np.log(number / samples), *(total[1:] / number)])


def loud(
    stacks: Sequence[Frames], lattices: Sequence[Lattice], gain_dn_per_e: Mapping[str, float]
) -> Loud:
    """The loud pixels of dark shots.

    Args:
        stacks: frames of each, more than the longest of `LAGS`.
        lattices: where their measured samples are.
        gain_dn_per_e: by channel.
    """
    grounds, counted = [], []
    for lattice in lattices if stacks else ():
        shots = [_own(lattice.of(stack.dn[:MOST_FRAMES])) for stack in stacks]
        ground = Ground(
            samples=shots[0].shape[1],
            gain_dn_per_e=gain_dn_per_e[lattice.channel],
            intervals_s=tuple(interval_of(stack.shot) for stack in stacks),
            darkness_s=tuple(darkness_s(stack.shot) for stack in stacks),
            variances_dn2=tuple(float(np.median(dn.var(axis=0, ddof=1))) for dn in shots),
            levels_dn=np.array([dn.mean(axis=0) for dn in shots], dtype=np.float64),
            frames=tuple(len(dn) for dn in shots),
        )
        grounds.append(ground)
        counted.append(shots)

    def figures(quartiles: tuple[float, float]) -> Floats:
        found = [figures_of(*one, quartiles) for one in zip(counted, grounds, strict=True)]
        return np.concatenate(found, axis=1) if found else np.zeros((FIGURES, 0))

    how_loud = figures(ALL)[HOW_LOUD]
    low, high = np.quantile(how_loud, (0.25, 0.75)) if len(how_loud) else ALL
    quartiles = float(low), float(high)
    return Loud(grounds=tuple(grounds), by_pixel=figures(quartiles), quartiles=quartiles)


def _own(dn: NDArray[np.generic]) -> Stack:
    """What each sample does by itself, (frames, samples): less what all of a frame do together."""
    flat = dn.reshape(len(dn), -1).astype(np.float32)
    together = flat.mean(axis=1, keepdims=True)
    return np.asarray(flat - (together - together.mean()))


def figures_of(shots: Sequence[Stack], ground: Ground, quartiles: tuple[float, float]) -> Floats:
    """Figures of the loud samples, (FIGURES, loud samples); the last one only of several shots.

    Args:
        shots: (frames, samples) of each.
        ground: what they are counted from.
        quartiles: between which a pixel is about as loud as the others.
    """
    samples = shots[0].shape[1]
    variance = np.zeros(samples)
    freedom = 0
    scaled = []
    for dn, typical_dn2 in zip(shots, ground.variances_dn2, strict=True):
        x = (dn - dn.mean(axis=0)) / np.float32(np.sqrt(max(typical_dn2, BETWEEN_CODES_DN2)))
        variance += np.square(x).sum(axis=0)
        freedom += len(x) - 1
        scaled.append(x)
    variance /= freedom
    is_loud = variance > ground.threshold
    variance = variance[is_loud]
    chosen = [x[:, is_loud] for x in scaled]
    stays = [
        np.mean([_means_of_products(x[:-lag], x[lag:]) for x in chosen], axis=0) / variance
        for lag in LAGS
    ]
    # in NumPy a third power takes forty times as long as two products
    leans = np.mean([_means_of_products(x, np.square(x)) for x in chosen], axis=0) / variance**1.5
    louder = np.log(variance)
    little = louder <= quartiles[0]
    usual = ~little & (louder < quartiles[1])
    figures = [np.ones(len(variance)), louder, usual, *stays, leans, little]
    if len(shots) > 1:
        longest = chosen[int(np.argmax(ground.darkness_s))]
        figures.append(np.square(longest).sum(axis=0) / (freedom * variance))
    return np.stack(figures).astype(np.float64)


def _means_of_products(one: Stack, other: Stack) -> Stack:
    """Over frames, of each sample."""
    return np.asarray(np.einsum("ij,ij->j", one, other) / np.float32(len(one)))
