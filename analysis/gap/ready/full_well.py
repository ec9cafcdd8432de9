"""The charge at which photosites are full: where light goes on and its noise does not.

Photons arrive with the variance of their number, but a full photosite holds the same charge in
every frame. Samples at the top of a picture that are quieter than those half as bright, beyond the
noise of the dark, are full, unless the converter ends there: then they hold at least what its last
code stands for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.look.lattices import Lattice
from sensor.frames import Frames

Floats = NDArray[np.float64]

MOST_FRAMES = 32
"""Of a shot, of which samples are read."""

TOP = 0.01
"""Part of the samples that are looked at as the brightest."""

MIDDLE = (0.4, 0.8)
"""Between the darkest and the brightest, the samples they are compared with."""

FEWEST = 30
"""Samples of each kind."""

QUIET = 0.6
"""Of their variance beyond that of the dark. By photons alone the brightest have from 1.2 to 2.5
times as much."""

CLEAR_OF_THE_TOP = 3.0
"""Standard deviations of light half as bright below the end of the converter from which on it
clips too few samples to make them quiet."""

SURELY = 4.0
"""Standard errors by which they are that quiet."""


def full_well_e(stacks: Sequence[Frames], lattices: Sequence[Lattice], base: Base) -> float | None:
    """The charge of full photosites, or the least that it may be; None of frames without any.

    Args:
        stacks: the frames of each shot; of the dark ones only their level and noise count.
        lattices: where samples are measured.
        base: the camera as it is calibrated, for electrons.
    """
    full: list[float] = []
    at_least: list[float] = []
    for lattice in lattices:
        c = base.channels.index(lattice.channel)
        seen = [samples_of(one, lattice) for one in lit(stacks)]
        for one, level in zip(seen, levels_of_full(seen, dark_of(stacks, lattice)), strict=True):
            end = one.top_dn if one.clipped else level
            if end is not None:
                charge_e = float((end - base.black_dn[c]) / base.gain_dn_per_e[c])
                (at_least if one.clipped else full).append(charge_e)
    if full:
        return float(np.median(full))
    return max(at_least, default=None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """Samples of one colour in one lit shot.

    Attributes:
        mean, variance: over its frames, (samples,).
        frames: their number.
        top_dn: the largest pixel value.
        clipped: whether more than a few lie there.
    """

    mean: Floats
    variance: Floats
    frames: int
    top_dn: int
    clipped: bool

    @staticmethod
    def of(dn: NDArray[np.float32], top_dn: int) -> Samples:
        """Of frames, (frames, rows, columns)."""
        return Samples(
            mean=dn.mean(axis=0).ravel().astype(float),
            variance=dn.var(axis=0, ddof=1).ravel().astype(float),
            frames=len(dn),
            top_dn=top_dn,
            clipped=float((dn >= top_dn).mean()) > TOP,
        )

    def brightest(self) -> tuple[float, Floats]:
        """Their level and their variances."""
        part = max(TOP, min(FEWEST / self.mean.size, 1.0))
        top = self.mean >= np.quantile(self.mean, 1 - part)
        return float(self.mean[top].mean()), self.variance[top]

    def between(self, least_dn: float, most_dn: float) -> Floats:
        """Variances of those that are so bright."""
        return self.variance[(self.mean > least_dn) & (self.mean < most_dn)]

    def error_of(self, variances: Floats) -> float:
        """Standard error of the mean of variances."""
        return float(variances.mean() * np.sqrt(2.0 / ((self.frames - 1) * variances.size)))


@dataclass(frozen=True, kw_only=True)
class Dark:
    """Mean and mean variance in time of dark samples; 0 where there are none."""

    mean_dn: float = 0.0
    variance_dn2: float = 0.0


def levels_of_full(shots: Sequence[Samples], dark: Dark) -> list[float | None]:
    """The level at which samples of one colour stop in each shot, in DN; None where they do not, or
    the converter ends first.

    Args:
        shots: their samples. Those half as bright may be of any of them.
        dark: samples without light, whose noise full ones have as well.
    """
    told = [one for one in shots if not one.clipped]
    return [None if one.clipped else _level_of_full(one, told, dark) for one in shots]


def _level_of_full(one: Samples, shots: Sequence[Samples], dark: Dark) -> float | None:
    level, bright = one.brightest()
    least_dn, most_dn = (dark.mean_dn + part * (level - dark.mean_dn) for part in MIDDLE)
    medium = np.concatenate([each.between(least_dn, most_dn) for each in shots])
    if min(bright.size, medium.size) < FEWEST:
        return None
    if level > one.top_dn - CLEAR_OF_THE_TOP * np.sqrt(medium.mean()):
        return None  # noise that the converter clips is quiet as well
    half, full = (float(some.mean()) - dark.variance_dn2 for some in (medium, bright))
    error = np.hypot(one.error_of(bright), QUIET * one.error_of(medium))
    # a curve that flattens takes noise from what is bright, and gives it to the dark
    return level if QUIET * half - abs(full) > SURELY * error else None


def dark_of(stacks: Sequence[Frames], lattice: Lattice) -> Dark:
    """Of the samples of a lattice in all dark shots."""
    darks = [_dn(one, lattice) for one in stacks if one.shot.dark and one.count >= 2]
    if not darks:
        return Dark()
    return Dark(
        mean_dn=float(np.mean([dn.mean() for dn in darks])),
        variance_dn2=float(np.mean([dn.var(axis=0, ddof=1).mean() for dn in darks])),
    )


def lit(stacks: Sequence[Frames]) -> list[Frames]:
    """Shots under a lamp whose noise can be told."""
    return [one for one in stacks if not one.shot.dark and one.count >= 2]


def samples_of(stack: Frames, lattice: Lattice) -> Samples:
    """Samples of a lattice in one shot."""
    return Samples.of(_dn(stack, lattice), stack.top_dn)


def _dn(stack: Frames, lattice: Lattice) -> NDArray[np.float32]:
    return lattice.of(stack.dn[:MOST_FRAMES]).astype(np.float32)
