"""A camera whose photosites are full in some shots, by what is well below in all of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.first_guess import BELOW_FULL, Full
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import NOT_CLIPPED
from analysis.gap.ready.full_well import FEWEST, dark_of, levels_of_full, lit, samples_of
from analysis.gap.ready.hints import Told
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting

Floats = NDArray[np.float64]

USUALLY_DRAINED = 0.8
"""Part of what is too much that a drain takes, where a search begins; then none."""

SHORT_ROWS = 5.0
"""Where a search begins at last: how far charge gets that the drain takes on the way. Charge that
runs for a while and is then lost gets as far."""


def brimful(setting: Setting) -> Told | None:
    """Where a search for the charge of full photosites begins, and the camera that is told by what
    is well below; None where no shot has full ones, or nothing is below.

    A camera that was calibrated to all of them has less gain and other light, as bright samples
    have neither the noise nor the level of theirs.

    Args:
        setting: the capture.
    """
    ends = _ends(setting)
    full = {label: levels for label, levels in ends.items() if np.isfinite(levels).any()}
    gain = _gain_below(setting, ends) if full else None
    if gain is None:
        return None
    _, base = by_moments(setting, full=Full(levels_dn=full, gain_dn_per_e=gain))
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
    ends_soon = dataclasses.replace(all_stays, hints={**all_stays.hints, "reach_rows": SHORT_ROWS})
    return dataclasses.replace(begin, instead=dataclasses.replace(all_stays, instead=ends_soon))


def _as_full(base: Base, above_dn: Floats, charge_e: float) -> Base:
    """The camera whose full photosites are where they are seen: gains by noise are told to some
    hundredths, and levels to less than a code. What it shows of its light stays as bright.

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


def _ends(setting: Setting) -> dict[str, Floats]:
    """Level of full photosites in DN by label of a lit shot, (channels,); infinite where there are
    none or the converter ends first.
    """
    shots = lit(setting.key_frames)
    found: list[dict[str, list[float]]] = [{c: [] for c in setting.seen.channels} for _ in shots]
    for lattice in setting.scenery.view.lattices:
        dark = dark_of(setting.key_frames, lattice)
        levels = levels_of_full([samples_of(one, lattice) for one in shots], dark)
        for by_channel, level in zip(found, levels, strict=True):
            if level is not None:
                by_channel[lattice.channel].append(level)
    return {
        stack.shot.label: np.array([np.mean(one) if one else np.inf for one in levels.values()])
        for stack, levels in zip(shots, found, strict=True)
    }


def _gain_below(setting: Setting, ends: Mapping[str, Floats]) -> Floats | None:
    """Gain in DN/e- by channel, by photon transfer of samples well below full: by how much more
    they change than dark ones, over how much brighter they are. None where there are too few.

    By medians of samples that are about as bright: what runs over from full ones comes and goes,
    and changes a few by far more than their own light.

    Args:
        setting: the capture.
        ends: level of full photosites by label of a lit shot, (channels,).
    """
    channels = setting.seen.channels
    more_dn2, above_dn = np.zeros((2, len(channels)))
    for lattice in setting.scenery.view.lattices:
        c = channels.index(lattice.channel)
        dark = dark_of(setting.key_frames, lattice)
        for stack in lit(setting.key_frames):
            one = samples_of(stack, lattice)
            ends_dn = min(ends[stack.shot.label][c], NOT_CLIPPED * stack.top_dn)
            below = np.flatnonzero(one.mean < dark.mean_dn + BELOW_FULL * (ends_dn - dark.mean_dn))
            darkest_first = below[np.argsort(one.mean[below])]
            count = len(below) // FEWEST
            for alike in np.array_split(darkest_first, count) if count else ():
                usual_dn2 = np.median(one.variance[alike]) / _median_of_variance(one.frames)
                more_dn2[c] += len(alike) * (usual_dn2 - dark.variance_dn2)
                above_dn[c] += len(alike) * (one.mean[alike].mean() - dark.mean_dn)
    told = (more_dn2 > 0).all() and (above_dn > 0).all()
    return more_dn2 / above_dn if told else None


def _median_of_variance(frames: int) -> float:
    """Median of the variance of so many normal numbers, over its mean: Wilson and Hilferty (1931)
    of chi-squared."""
    return float((1.0 - 2.0 / (9.0 * (frames - 1))) ** 3)
