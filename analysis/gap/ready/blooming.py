"""A camera whose photosites are full in some shots, by what is well below in all of them."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.first_guess import Full
from analysis.gap.camera.base import Base
from analysis.gap.ready.full_well import dark_of, levels_of_full, lit, samples_of
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting
from analysis.gap.ready.typical_noise import gain_below

Floats = NDArray[np.float64]

USUALLY_DRAINED = 0.8
"""Part of what is too much that a drain takes, where a search begins; then none."""

SHORT_ROWS = 5.0
"""Where a search begins at last: how far charge gets that the drain takes on the way. Charge that
runs for a while and is then lost gets as far."""


def brimful(setting: Setting) -> DirectReading | None:
    """Where a search for the charge of full photosites begins, and the camera that is told by what
    is well below; None where no shot has full ones, or nothing is below.

    A camera that was calibrated to all of them has less gain and other light, as bright samples
    have neither the noise nor the level of theirs. So it has where the converter ends first: what
    lies there may be full, at least with what its last code stands for.

    Args:
        setting: the capture.
    """
    ends = _ends(setting)
    some = {label: one for label, one in ends.items() if np.isfinite(one.at_least_dn).any()}
    full_dn = {label: one.full_dn for label, one in ends.items()}
    gain = gain_below(setting, full_dn) if some else None
    if gain is None:
        return None
    at_least_dn = {label: one.at_least_dn for label, one in some.items()}
    _, base = by_moments(setting, full=Full(levels_dn=at_least_dn, gain_dn_per_e=gain))
    above_dn = np.array([one.full_dn for one in some.values()]) - base.black_dn
    told = np.isfinite(above_dn)
    if told.any():
        charge_e = float(np.median((above_dn / base.gain_dn_per_e)[told]))
        base = _as_full(base, np.where(told, above_dn, np.nan), charge_e)
    else:
        held_e = (np.array(list(at_least_dn.values())) - base.black_dn) / base.gain_dn_per_e
        charge_e = float(held_e[np.isfinite(held_e)].max())
    # a light that was made to look like full photosites has none to be filled
    begin = DirectReading(
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


@dataclass(frozen=True, kw_only=True, eq=False)
class _Ends:
    """Where the samples of a lit shot end, in DN.

    Attributes:
        full_dn: level of full photosites, infinite where none are seen, (channels,).
        at_least_dn: the same, and the end of the converter where samples lie there, (channels,).
    """

    full_dn: Floats
    at_least_dn: Floats


def _ends(setting: Setting) -> dict[str, _Ends]:
    """Where samples end by label of a lit shot."""
    shots, channels = lit(setting.key_frames), setting.seen.channels
    full: list[dict[str, list[float]]] = [{c: [] for c in channels} for _ in shots]
    end = np.full((len(shots), len(channels)), np.inf)
    for lattice in setting.scenery.view.lattices:
        samples = [samples_of(one, lattice) for one in shots]
        levels = levels_of_full(samples, dark_of(setting.key_frames, lattice))
        for k, (one, level) in enumerate(zip(samples, levels, strict=True)):
            if one.clipped:
                end[k, channels.index(lattice.channel)] = one.top_dn
            elif level is not None:
                full[k][lattice.channel].append(level)
    full_dn = np.array([[np.mean(c) if c else np.inf for c in one.values()] for one in full])
    return {
        stack.shot.label: _Ends(full_dn=seen, at_least_dn=np.minimum(seen, clipped))
        for stack, seen, clipped in zip(shots, full_dn, end, strict=True)
    }
