"""The charge at which photosites are full: where light goes on and its noise does not.

Photons arrive with the variance of their number, but a full photosite holds the same charge in
every frame. Samples at the top of a picture that are quieter than those half as bright are full,
unless the converter ends there: then they hold at least what its last code stands for.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.look.lattices import Lattice
from sensor.frames import Frames

MOST_FRAMES = 32

TOP = 0.01
"""Part of the samples that are looked at as the brightest."""

MIDDLE = (0.4, 0.8)
"""Between the darkest and the brightest, the samples they are compared with."""

FEWEST = 30
"""Samples of each kind."""

QUIET = 0.6
"""Of their variance. By photons alone the brightest have from 1.2 to 2.5 times as much, and the
mean of the variance of `FEWEST` samples in 8 frames has an error of a tenth."""


def full_well_e(stacks: Sequence[Frames], lattices: Sequence[Lattice], base: Base) -> float | None:
    """The charge of full photosites, or the least that it may be; None of frames without any.

    Args:
        stacks: the frames of each shot; the dark ones are left out.
        lattices: where samples are measured.
        base: the camera as it is calibrated, for electrons.
    """
    full: list[float] = []
    at_least: list[float] = []
    for stack in stacks:
        if stack.shot.dark or stack.count < 2:
            continue
        for lattice in lattices:
            c = base.channels.index(lattice.channel)
            dn = lattice.of(stack.dn[:MOST_FRAMES]).astype(np.float32)
            clipped = float((dn >= stack.top_dn).mean()) > TOP
            level = stack.top_dn if clipped else level_of_full(dn)
            if level is not None:
                charge_e = float((level - base.black_dn[c]) / base.gain_dn_per_e[c])
                (at_least if clipped else full).append(charge_e)
    if full:
        return float(np.median(full))
    return max(at_least, default=None)


def level_of_full(dn: NDArray[np.float32]) -> float | None:
    """The level at which samples stop, in DN; None where they do not.

    Args:
        dn: samples of one colour, (frames, rows, columns), none of them clipped.
    """
    mean, variance = dn.mean(axis=0), dn.var(axis=0, ddof=1)
    top = mean >= np.quantile(mean, 1 - TOP)
    level, darkest = float(mean[top].mean()), float(np.quantile(mean, TOP))
    part = (mean - darkest) / max(level - darkest, 1e-6)
    middle = (part > MIDDLE[0]) & (part < MIDDLE[1])
    if min(np.count_nonzero(top), np.count_nonzero(middle)) < FEWEST:
        return None
    return level if variance[top].mean() < QUIET * variance[middle].mean() else None
