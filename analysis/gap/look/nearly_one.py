"""Gains of a white balance on whole codes that are nearly 1, by the few teeth of red and blue."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.comb import (
    MANY_ORIGINS,
    MOST_CODES,
    NEAR,
    OF_FEW_TEETH,
    SLACK,
    Teeth,
    combs,
    few_teeth_of,
    like_few,
)
from sensor.colours import CHANNELS
from sensor.effects.white_balance import WhiteBalance

Floats = NDArray[np.float64]

LEAST = 0.002
"""A gain nearer to 1 than this leaves no code out of 8 bits, and takes none twice."""

STEP = 1e-4

NEARLY_ONE = 1.0 + np.concatenate([-np.arange(LEAST, NEAR, STEP), np.arange(LEAST, NEAR, STEP)])


def nearly_one(counts: Mapping[str, Floats], black_dn: float) -> tuple[WhiteBalance, ...]:
    """Gains of red and blue by the one tooth or the few that either has and green has not, about
    the black level and about code 0, which so few teeth may leave open; the likelier first.

    Args:
        counts: histograms by channel.
        black_dn: a first black level.
    """
    if set(counts) != set(CHANNELS) or len(counts["G"]) > MOST_CODES:
        return ()
    teeth = {channel: few_teeth_of([one]) for channel, one in counts.items()}
    found: list[tuple[float, WhiteBalance]] = []
    for about_black, origins in ((1.0, black_dn + MANY_ORIGINS), (0.0, np.zeros(1))):
        part = {c: _gain_of(one, origins, len(counts["G"])) for c, one in teeth.items()}
        if part["G"] is not None:
            return ()
        (of_red, red), (of_blue, blue) = (part[c] or (0.0, 1.0) for c in ("R", "B"))
        if of_red or of_blue:
            gains = WhiteBalance(red_gain=red, blue_gain=blue, about_black=about_black)
            found.append((of_red + of_blue, gains))
    if len(found) == 2 and found[1][0] > found[0][0] + SLACK:
        found.reverse()  # else either is as good, and most cameras leave black as it is
    return tuple(gains for _, gains in found)


def _gain_of(teeth: Teeth | None, origins: Floats, size: int) -> tuple[float, float] | None:
    """How much of a channel's teeth a gain explains, and the gain; None where none does."""
    if teeth is None:
        return None
    codes = np.arange(float(size))[:, None]
    part, gain = max(
        like_few(teeth, NEARLY_ONE, combs(at + (codes - at) * NEARLY_ONE, size)) for at in origins
    )
    return (part, gain) if part > OF_FEW_TEETH else None
