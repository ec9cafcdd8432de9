"""Correction of defect pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter, switch
from sensor.limits import greater, lesser
from sensor.neighbours import Runs, interleaved
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class DefectCorrection(Effect):
    """A pixel that stands out from its surroundings is taken for a defect and replaced.

        DN' = m where |DN - m| > T, else DN;    m = median of the eight nearest of the same colour

    or where DN is beyond all eight of them by T, which leaves the slopes of a picture alone. It
    acts on the samples before they are demosaiced. Nothing changes where noise and detail stay
    within T; an isolated outlier above T vanishes whole, however high it is, and one below T stays
    as it was. A blur keeps the sum of an outlier and of its surroundings instead. The tails of the
    noise beyond T go too.
    """

    name: ClassVar[str] = "defect_correction"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 5
    reference: ClassVar[str] = (
        "Nakamura (ed.), Image Sensors and Signal Processing for Digital Still Cameras (2006), "
        "chapter 8; Tukey, Exploratory Data Analysis (1977), for the running median"
    )

    threshold_dn: float = parameter(
        6.0,
        unit="DN",
        minimum=0.0,
        maximum=65536.0,
        identity=65536.0,
        starts=(1.5, 6.0, 24.0, 48.0, 96.0, 136.0, 192.0),
        doc="difference from the median from which a pixel is a defect",
    )

    beyond_all: float = switch(
        0.0,
        starts=(0.0, 1.0),
        doc="1 where a defect is beyond all eight by that, 0 where it is from their median",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        step = 2 if len(set(signal.format.cfa)) > 1 else 1
        threshold = signal.backend.tensor([self.threshold_dn]).array
        runs = Runs(signal)
        above, here, below = (runs.line(dy, step) for dy in (-step, 0, step))
        parts = []
        for k in range(runs.length):
            left, own, right = k, k + step, k + 2 * step
            around = [above[left], above[own], above[right], here[right]]
            around += [below[right], below[own], below[left], here[left]]
            lowest, median, highest = _in_order(around)
            if not self.beyond_all:
                lowest = highest = median
            good = (here[own] <= highest + threshold) & (here[own] >= lowest - threshold)
            parts.append(dr.select(good, here[own], median))
        return signal.replace(type(signal.value)(interleaved(parts), signal.shape))


def _in_order(values: list[Any]) -> tuple[Any, Any, Any]:
    """The least of eight arrays, the mean of the two middle ones, and the largest, lane by lane."""
    low, high = _sorted_four(values[:4]), _sorted_four(values[4:])
    # the four smallest of eight are min(a_i, b_(3-i)) of two sorted fours, the largest the max
    pairs = list(zip(low, reversed(high), strict=True))
    lower, upper = lesser(*pairs[0]), greater(*pairs[0])
    for a, b in pairs[1:]:
        lower = greater(lower, lesser(a, b))
        upper = lesser(upper, greater(a, b))
    return lesser(low[0], high[0]), 0.5 * (lower + upper), greater(low[3], high[3])


def _sorted_four(values: list[Any]) -> list[Any]:
    """Four arrays in ascending order, lane by lane, by the network of five exchanges."""
    v = list(values)
    for i, j in ((0, 1), (2, 3), (0, 2), (1, 3), (1, 2)):
        v[i], v[j] = lesser(v[i], v[j]), greater(v[i], v[j])
    return v
