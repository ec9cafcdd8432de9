"""Quantization."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.limits import between
from sensor.signal import Quantity, Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Quantization(Effect):
    """Round to the nearest whole DN, and clip to the range of the bits.

    Adds a variance of 1/12 DN^2 where the noise is well above a step, and anything between nothing
    and much where it is not. A converter of b more bits than leave the camera gives n = 2^b steps
    in a code, and its halves go to the even code: even codes have n + 1 of these steps, odd ones
    n - 1, so that their counts differ by 2/n of their mean.
    """

    name: ClassVar[str] = "quantization"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 1000
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equations (1) and (2)"

    steps: float = parameter(
        1.0,
        unit="1",
        minimum=1.0,
        maximum=256.0,
        whole=True,
        doc="of the converter in a code that leaves the camera: 1, or 4 where two bits are dropped",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        top, steps = float(signal.format.top_dn), self.steps

        def code(value: Any) -> Any:
            counted = dr.round(value * steps) * (1.0 / steps) if steps > 1 else value
            return between(dr.round(counted), 0.0, top)

        return signal.pointwise(code, quantity=Quantity.CODE)
