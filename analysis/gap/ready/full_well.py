"""The charge at which photosites are full: where light goes on and its noise does not.

Photons arrive with the variance of their number, but a full photosite holds the same charge in
every frame. Samples at the top of a picture that are quieter than those half as bright are full,
unless the converter ends there: then they hold at least what its last code stands for.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.hints import Told
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting
from sensor.frames import Frames

Floats = NDArray[np.float64]

MOST_FRAMES = 32

TOP = 0.01
"""Part of the samples that are looked at as the brightest."""

MIDDLE = (0.4, 0.8)
"""Between the darkest and the brightest, the samples they are compared with."""

FEWEST = 30
"""Samples of each kind."""

USUALLY_DRAINED = 0.8
"""Part of what is too much that a drain takes, where a search begins; then none."""

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
            dn = _samples(stack, lattice)
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


def brimful(setting: Setting) -> Told | None:
    """Where a search for the charge of full photosites begins, and the camera that is told by shots
    without any, and by what is well below in those that have some; None where no shot has, or all.

    A camera that was calibrated to all of them has less gain and other light, as bright samples
    have neither the noise nor the level of theirs.

    Args:
        setting: the capture.
    """
    lit = [stack for stack in setting.key_frames if not stack.shot.dark and stack.count >= 2]
    full = {stack.shot.label: ends for stack in lit if (ends := _ends(stack, setting)) is not None}
    if not full or len(full) == len(lit):
        return None
    _, base = by_moments(setting, full=full)
    above_dn = np.array(list(full.values())) - base.black_dn
    told = np.isfinite(above_dn)
    charge_e = float(np.median((above_dn / base.gain_dn_per_e)[told]))
    base = _as_full(base, np.where(told, above_dn, np.nan), charge_e)
    # a light that was made to look like full photosites has none to be filled
    begin = Told(
        hints={"full_well_e": charge_e, "drained": USUALLY_DRAINED},
        exact=False,
        base=base,
        scenery=setting.scenery,
    )
    all_stays = dataclasses.replace(begin, hints={**begin.hints, "drained": 0.0})
    return dataclasses.replace(begin, instead=all_stays)


def _as_full(base: Base, above_dn: Floats, charge_e: float) -> Base:
    """The camera whose full photosites are where they are seen: gains by noise are told to a
    hundredth, and levels to a thousandth. What it shows of its light stays as bright.

    Args:
        base: by moments.
        above_dn: levels above black, not a number where none was seen, (shots, channels).
        charge_e: of a full photosite.
    """
    seen = np.isfinite(above_dn).any(axis=0)
    gain = base.gain_dn_per_e.copy()
    gain[seen] = np.nanmean(above_dn[:, seen], axis=0) / charge_e
    dimmer = base.gain_dn_per_e / gain
    level = {lamp: of_lamp * dimmer for lamp, of_lamp in base.level.items()}
    return dataclasses.replace(base, gain_dn_per_e=gain, level=level)


def _ends(stack: Frames, setting: Setting) -> Floats | None:
    """Level of full photosites in DN by channel, infinite where there are none or the converter
    ends first; None of a shot without any.
    """
    lattices = setting.scenery.view.lattices
    found = [(one.channel, level_of_full(_samples(stack, one))) for one in lattices]
    levels = [
        [v for channel, v in found if channel == c and v is not None and v < stack.top_dn - 1]
        for c in setting.seen.channels
    ]
    ends = np.array([np.mean(one) if one else np.inf for one in levels])
    return ends if np.isfinite(ends).any() else None


def _samples(stack: Frames, lattice: Lattice) -> NDArray[np.float32]:
    return lattice.of(stack.dn[:MOST_FRAMES]).astype(np.float32)
