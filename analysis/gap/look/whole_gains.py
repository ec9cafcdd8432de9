"""A white balance on whole codes, told by the combs of red and blue."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.comb import GAINS, LEAST_COUNT, NEAR, SLACK, combs, fitting, teeth_of
from sensor.colours import CHANNELS
from sensor.effects.white_balance import WhiteBalance

Floats = NDArray[np.float64]

WINDOWED = 512
"""Of finer codes so many are looked at for a gain, which shows in every dozen of them."""

STEP = 64
"""Such windows begin at multiples of this, so that channels have most of them in common."""

LARGE_GAINS = np.round(np.arange(2.0, 3.2, 5e-4), 4)
"""Gains of which every second or third code is hit; see `MIRRORED`."""

MIRRORED = 0.03
"""By how much more a histogram is like the comb of a large gain, of which every second or third
code is hit: those of smaller gains are nearly its mirror images, and more frequent."""

OFFSETS = np.sort(np.append(np.arange(0.0, 2.0, 0.1), [1e-3, 2.0 - 1e-3]))
"""Of a tenth of a code, and next to none: by which halves go up or down."""

AS_GOOD_AS_ZERO = 0.15
"""Of a code, either way of a whole number of gains, within which an offset is none."""

ALIKE = 0.57
"""Correlation of a histogram with the comb of a gain that it has; others have up to 0.5."""

MORE = 0.1
"""By how much more a histogram is like its comb than that of green is like any: where noise is low,
patches of a chart have teeth of their own, and few codes are like some gain by chance."""


def white_balance(counts: Mapping[str, Floats], step: int = 1) -> WhiteBalance | None:
    """Gains of whole red and blue codes against green; None where neither has the comb of one.

    Args:
        counts: histograms by channel.
        step: from one code of the converter to the next, where its lowest bits are lost.
    """
    if set(counts) != set(CHANNELS):
        return None
    found = _gains_of(counts, step)
    # where green has a comb as well, all codes are counted in other steps
    other_steps = step == 1 and found["G"] is not None
    if other_steps or (found["R"] is None and found["B"] is None):
        return None
    red, blue = found["R"] or (1.0, False), found["B"] or (1.0, False)
    if red[0] == blue[0] == 1.0:
        return None
    return WhiteBalance(red_gain=red[0], blue_gain=blue[0], about_black=float(red[1] or blue[1]))


def _gains_of(counts: Mapping[str, Floats], step: int) -> dict[str, tuple[float, bool] | None]:
    """Gain of each histogram, and whether it leaves a black level alone; None without a comb."""
    # where steps are wide a gain of 1 has a comb as well
    near = NEAR if step == 1 else 0.0
    first = {channel: _first(one) for channel, one in counts.items()}
    teeth = {channel: teeth_of(one[first[channel] :][:WINDOWED]) for channel, one in counts.items()}
    found: dict[str, list[tuple[float, float, float]]] = {channel: [] for channel in counts}
    for low in {first[channel] for channel, one in teeth.items() if one is not None}:
        size = min(WINDOWED, len(counts["G"]) - low)
        for gains, less in ((GAINS, 0.0), (LARGE_GAINS, MIRRORED)):
            # a gain below 1 fills a window from more codes than it has, if there are more
            whole = np.floor(low / gains) + np.arange(min(2 * size, len(counts["G"])))[:, None]
            whole = whole[::step] // step * step
            for at in step * OFFSETS:
                every = combs(whole * gains + at - low, size)
                for channel, one in teeth.items():
                    if one is not None and first[channel] == low:
                        alike, gain = fitting(one, gains, every, near)
                        found[channel].append((alike - less, gain, float(at)))
    chance = max((alike for alike, _, _ in found["G"]), default=0.0) if step == 1 else 0.0
    least = {channel: ALIKE if channel == "G" else max(ALIKE, chance + MORE) for channel in found}
    return {channel: _roundest_pair(one, least[channel]) for channel, one in found.items()}


def _first(counts: Floats) -> int:
    """Where to look in a histogram: at all of few codes, of many from the first frequent one."""
    often = np.flatnonzero(counts > LEAST_COUNT)
    if len(counts) <= WINDOWED or len(often) == 0:
        return 0
    return min(int(often[0]), len(counts) - WINDOWED) // STEP * STEP


def _roundest_pair(
    found: Sequence[tuple[float, float, float]], least: float
) -> tuple[float, bool] | None:
    """Of likeness, gain and offset the gain that fits, and whether there is an offset.

    A little more gain is a little less offset: the roundest pair of those that fit alike.
    """
    best = max((alike for alike, _, _ in found), default=0.0)
    if best < least:
        return None
    _, off_zero, gain = min(
        (len(f"{gain:g}"), not _nothing(at, gain), gain)
        for one, gain, at in found
        if one > best - SLACK
    )
    return gain, off_zero


def _nothing(offset: float, gain: float) -> bool:
    """Whether an offset is some whole codes' worth of gain, so that the codes begin at 0."""
    beyond = offset % gain
    return bool(min(beyond, gain - beyond) < AS_GOOD_AS_ZERO)
