"""Quantization."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage
from sensor.limits import between
from sensor.signal import Quantity, Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Quantization(Effect):
    """Round to the nearest whole DN, and clip to the range of the bits.

    Adds a variance of 1/12 DN^2 where the noise is well above a step, and anything between nothing
    and much where it is not.
    """

    name: ClassVar[str] = "quantization"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 1000
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equations (1) and (2)"

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        top = float(signal.format.top_dn)
        return signal.pointwise(
            lambda value: between(dr.round(value), 0.0, top), quantity=Quantity.CODE
        )
