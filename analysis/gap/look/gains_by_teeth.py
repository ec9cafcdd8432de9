"""Gains of a white balance on whole codes that are near 1, by the few teeth of red and blue.

A gain of 1.02 leaves out every fiftieth code. So few teeth are no comb to which a whole histogram
could be compared, but each of them says to the very code where a product was rounded up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.comb import (
    MANY_ORIGINS,
    MOST_CODES,
    OF_FEW_TEETH,
    SLACK,
    Teeth,
    combs,
    explained,
    few_teeth_of,
)
from analysis.gap.look.finer_gains import Gains
from sensor.colours import CHANNELS
from sensor.effects.white_balance import WhiteBalance

Floats = NDArray[np.float64]

LEAST = 0.002
"""A gain nearer to 1 than this leaves no code out of 8 bits, and takes none twice."""

MOST = 0.15
"""A gain farther from 1 than this has teeth that are not alone in what is looked at beside one."""

STEP = 1e-4
"""From one gain that is tried to the next."""

NEAR_ONE = 1.0 + np.concatenate([-np.arange(LEAST, MOST, STEP), np.arange(LEAST, MOST, STEP)])

A_TOOTH = 0.5
"""A code that is left out has none of what those beside it have, and one taken twice has double."""

CLOSER_GAINS = np.arange(-1.2e-3, 1.2e-3, 2e-5)
"""Of gains around the likeliest, which are tried again."""

AS_EXACT = 0.005
"""Part of the teeth that exact combs may explain less and still fit as well."""

RIVAL = 0.1
"""The same where black or code 0 are what gains leave alone."""

OF_GREEN = 0.25
"""Part of what is uneven in green that a gain may explain by chance: up to 0.15 of 40 cameras."""


@dataclass(frozen=True, kw_only=True)
class _Told:
    """Gains by channel, of those that have teeth, and the part of their teeth that they explain."""

    origin_dn: float
    gains: Mapping[str, float]
    part: float


def gains_by_teeth(counts: Mapping[str, Floats], black_dn: float) -> tuple[Gains, ...]:
    """Gains of red and blue by the one tooth or the few that either has and green has not, about
    the black level or about code 0; both where so few teeth leave it open, the likelier first. The
    gain of a channel without such teeth is 1.

    Args:
        counts: histograms by channel.
        black_dn: a first black level.
    """
    if set(counts) != set(CHANNELS) or len(counts["G"]) > MOST_CODES:
        return ()
    teeth = {c: few for c, one in counts.items() if (few := few_teeth_of([one])) is not None}
    if not any(np.abs(teeth[c][1]).max() > A_TOOTH for c in "RB" if c in teeth):
        return ()
    found: list[Gains] = []
    parts: list[float] = []
    for about_black, origins_dn in ((1.0, black_dn + MANY_ORIGINS), (0.0, np.zeros(1))):
        told = _told(teeth, origins_dn, len(counts["G"]))
        if told is not None:
            red, blue = (told.gains.get(c, 1.0) for c in "RB")
            balance = WhiteBalance(red_gain=red, blue_gain=blue, about_black=about_black)
            found.append(Gains(white_balance=balance, origin_dn=told.origin_dn))
            parts.append(told.part)
    if len(found) == 2 and parts[1] > parts[0] + SLACK:
        found.reverse()  # else either is as good, and most cameras leave black as it is
        parts.reverse()
    return tuple(one for one, part in zip(found, parts, strict=True) if part > parts[0] - RIVAL)


def _told(teeth: Mapping[str, Teeth], origins_dn: Floats, size: int) -> _Told | None:
    """Gains about one of some origins, which both colours have in common; None where green has
    teeth as well, or neither has those of a gain.
    """
    of_origins = [_combs(at, NEAR_ONE, size) for at in origins_dn]
    roughly = {c: np.array([explained(t, one) for one in of_origins]) for c, t in teeth.items()}
    gains = {c: NEAR_ONE[one.max(axis=0).argmax()] + CLOSER_GAINS for c, one in roughly.items()}
    told = {
        c: np.array([explained(teeth[c], _combs(at, k, size), off=0.0) for at in origins_dn])
        for c, k in gains.items()
    }
    if "G" in told and told["G"].max() > OF_GREEN:
        return None
    told = {c: one for c, one in told.items() if c != "G" and one.max() > OF_FEW_TEETH}
    if not told:
        return None
    # the middle of all gains and origins that hit each code as often as it is seen
    of_both = np.sum([one.max(axis=1) for one in told.values()], axis=0)
    as_good = np.flatnonzero(of_both > of_both.max() - AS_EXACT * len(told))
    middle = int(as_good[len(as_good) // 2])
    likely = {c: one[middle] > one[middle].max() - AS_EXACT for c, one in told.items()}
    return _Told(
        origin_dn=float(origins_dn[middle]),
        gains={c: float(gains[c][one].mean()) for c, one in likely.items()},
        part=float(of_both[middle]),
    )


def _combs(origin_dn: float, gains: Floats, size: int) -> Floats:
    """Of gains about an origin, (codes, n)."""
    codes = np.arange(float(size))[:, None]
    return combs(origin_dn + (codes - origin_dn) * gains, size)
