"""Quantization."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.limits import between
from sensor.signal import Quantity, Signal
from sensor.stream import Stream

NEARLY_HALF_DN = 2.0**-10
"""Beyond the rounding errors of single precision at 14 bits."""


@dataclass(frozen=True, kw_only=True)
class Quantization(Effect):
    """Round to the nearest whole DN, and clip to the range of the bits.

    Adds a variance of 1/12 DN^2 where the noise is well above a step, and anything between nothing
    and much where it is not. A converter of b more bits than leave the camera gives n = 2^b steps
    in a code, and its halves go to the even code: even codes have n + 1 of these steps, odd ones
    n - 1, so that their counts differ by 2/n of their mean. Means of two or four codes often lie
    half way between two others. Which way these go is a matter of the circuit, and of the order of
    additions where a program weighs neighbours: a thousandth of a step decides.
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

    halves: float = parameter(
        0.0,
        unit="1",
        minimum=-1.0,
        maximum=1.0,
        whole=True,
        doc="of a code and what is within 2^-10 of one: 1 is up, -1 down, and with 0 exact ones "
        "alone go to the even code",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        top, steps = float(signal.format.top_dn), self.steps
        number = dr.array_t(signal.backend.arrays.TensorXf)
        # a figure that is data, so that the other way compiles nothing
        lean = dr.opaque(number, self.halves * NEARLY_HALF_DN) if self.halves else None

        def code(value: Any) -> Any:
            counted = dr.round(value * steps) * (1.0 / steps) if steps > 1 else value
            counted = counted if lean is None else counted + lean
            return between(dr.round(counted), 0.0, top)

        return signal.pointwise(code, quantity=Quantity.CODE)
