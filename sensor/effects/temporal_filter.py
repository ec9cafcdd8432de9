"""Recursive noise filter in time."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.film import Film
from sensor.signal import Signal
from sensor.stream import Stream

_FORGOTTEN = 1e-4
"""Weight of an earlier frame below which it is left out."""


@dataclass(frozen=True, kw_only=True)
class TemporalFilter(Effect):
    """The camera averages each frame with what it gave before, to look less noisy.

        y_k = (1 - a) x_k + a y_(k-1)

    Temporal variance falls by (1 - a) / (1 + a) and frames d apart are correlated by a^d, dark ones
    too, while fixed patterns pass unchanged: blurring in space correlates pixels, not frames. The
    memory is cut where a^d falls below 1e-4 and the rest scaled to a sum of 1.
    """

    name: ClassVar[str] = "temporal_filter"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 45
    reference: ClassVar[str] = (
        "Dennis, Nonlinear temporal filter for television picture noise reduction, "
        "IEE Proc. G 127, 52 (1980): the linear, first-order case"
    )

    carried: float = parameter(
        0.3,
        unit="1",
        minimum=0.0,
        maximum=0.9,
        identity=0.0,
        doc="part of the previous output in a frame: a",
    )

    @property
    def _doublings(self) -> int:
        """The sum holds 2^m frames: the fewest whose next one is forgotten."""
        if self.carried == 0:
            return 0
        return math.ceil(math.log2(math.log(_FORGOTTEN) / math.log(self.carried)))

    @property
    def history_frames(self) -> int:  # type: ignore[override]
        """Frames before the first one that it takes part of."""
        return int(2**self._doublings) - 1

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.shape[0] == 1:
            return signal.replace(signal.value)
        made = signal.interpolated
        if made and made.linear:  # a third of the numbers
            return dataclasses.replace(made, mosaic=self._filtered(made.mosaic)).signal()
        return self._filtered(signal)

    def _filtered(self, signal: Signal) -> Signal:
        # sum of a^d over d < 2^m as a product of sums over 8 frames each, 1, 8, 64 frames apart
        scale = (1.0 - self.carried) / (1.0 - self.carried ** (2**self._doublings))
        for done in range(0, self._doublings, 3):
            step, terms = 2**done, 2 ** min(3, self._doublings - done)
            weights = [scale * self.carried ** (step * d) for d in range(terms)]
            signal = signal.replace(Film.of(signal).filtered(weights, step))
            scale = 1.0
        return signal
