"""Pixels that are louder in time than noise makes any: how many, how loud, and in what way.

A pixel counts from a threshold that one of a hundred thousand passes by chance. Its figures are

    ln(variance / variance of the typical pixel)       how loud
    mean of x(t) x(t + k) / variance                   how much of it stays after k frames
    mean of x(t)^3 / variance^1.5                      whether it is more often down than up

of its own frames x about their own mean. That mean, the threshold and the rounding to codes bend
all of them; whoever holds simulated pixels against them has to look at those by this code.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.lattices import Lattice
from sensor.frame_times import interval_of
from sensor.frames import Frames

Floats = NDArray[np.float64]

MOST_FRAMES = 64
"""Of a shot."""

LOUD = 6.0
"""Standard errors of a variance in time by which it exceeds the typical one, if noise is normal."""

LAGS = (1, 2, 4, 8)
"""Frames after which a pixel is held against itself."""

RESAMPLED = 400
"""Times that pixels are drawn anew for the covariance of their figures."""


@dataclass(frozen=True, kw_only=True)
class Ground:
    """The samples of one lattice in one shot.

    Attributes:
        frames, samples: how many.
        variance_dn2: in time, of the typical sample.
        gain_dn_per_e: of its channel.
        interval_s: from frame to frame.
    """

    frames: int
    samples: int
    variance_dn2: float
    gain_dn_per_e: float
    interval_s: float

    @property
    def threshold_dn2(self) -> float:
        """Variance in time from which a sample is loud."""
        return self.variance_dn2 * (1.0 + LOUD * float(np.sqrt(2.0 / (self.frames - 1))))


@dataclass(frozen=True, kw_only=True)
class Loud:
    """What the loud pixels of several shots of one body show.

    Attributes:
        grounds: of every shot and lattice.
        samples: of all of them.
        by_pixel: figures of pixels that are loud once at least, (figures, pixels), summed over the
            shots in which they are: the first one is the number of these shots.
    """

    grounds: tuple[Ground, ...]
    samples: int
    by_pixel: Floats

    @property
    def pixels(self) -> int:
        """How many are loud in some shot."""
        return self.by_pixel.shape[1]

    @property
    def seen(self) -> Floats:
        """The figures; see `summary`."""
        return summary(self.by_pixel.sum(axis=1), self.samples)

    @property
    def covariance(self) -> Floats:
        """Of the figures: who is loud is chance, and the same pixels are in all shots."""
        drawn = np.random.default_rng(0).poisson(1.0, (RESAMPLED, self.pixels))
        again = [summary(self.by_pixel @ times, self.samples) for times in drawn]
        return np.cov(np.transpose(again))


def summary(total: Floats, samples: float) -> Floats:
    """Figures of loud pixels by their sum: ln(their share), and the means of the others."""
    number = max(float(total[0]), 0.5)
    return np.array([np.log(number / samples), *(total[1:] / number)])


def loud(
    stacks: Iterable[Frames], lattices: Sequence[Lattice], gain_dn_per_e: Mapping[str, float]
) -> Loud:
    """The loud pixels of dark shots.

    Args:
        stacks: frames of each, more than the longest of `LAGS`.
        lattices: where their measured samples are.
        gain_dn_per_e: by channel.
    """
    grounds, total = [], None
    for stack in stacks:
        of_shot = []
        for lattice in lattices:
            dn = lattice.of(stack.dn[:MOST_FRAMES]).astype(np.float32)
            dn = dn.reshape(len(dn), -1)
            # what all pixels of a frame do together is nobody's own
            dn -= dn.mean(axis=1, keepdims=True)
            ground = Ground(
                frames=len(dn),
                samples=dn.shape[1],
                variance_dn2=max(_typical(dn), ROUNDING_DN2),
                gain_dn_per_e=gain_dn_per_e[lattice.channel],
                interval_s=interval_of(stack.shot),
            )
            is_loud, figures = figures_of(dn, ground)
            everywhere = np.zeros((len(figures), dn.shape[1]))
            everywhere[:, is_loud] = figures
            of_shot.append(everywhere)
            grounds.append(ground)
        now = np.concatenate(of_shot, axis=1)
        total = now if total is None else total + now
    if total is None:
        total = np.zeros((3 + len(LAGS), 0))
    return Loud(
        grounds=tuple(grounds),
        samples=sum(ground.samples for ground in grounds),
        by_pixel=total[:, total[0] > 0],
    )


def figures_of(dn: NDArray[np.float32], ground: Ground) -> tuple[NDArray[np.bool_], Floats]:
    """Which samples are loud, and the figures of these, (figures, loud samples).

    Args:
        dn: (frames, samples).
        ground: what the threshold is counted from.
    """
    x = dn - dn.mean(axis=0)
    variance = np.square(x).sum(axis=0) / (len(x) - 1)
    is_loud = variance > ground.threshold_dn2
    x, variance = x[:, is_loud], variance[is_loud]
    stays = [(x[:-lag] * x[lag:]).mean(axis=0) / variance for lag in LAGS]
    leans = (x**3).mean(axis=0) / variance**1.5
    louder = np.log(variance / ground.variance_dn2)
    return is_loud, np.stack([np.ones(len(variance)), louder, *stays, leans]).astype(np.float64)


def _typical(dn: NDArray[np.float32]) -> float:
    """Variance in time of normal noise whose median over pixels is the one seen."""
    freedom = len(dn) - 1
    median = float(np.median(dn.var(axis=0, ddof=1)))
    return median / (1.0 - 2.0 / (9.0 * freedom)) ** 3
