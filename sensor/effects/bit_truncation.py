"""Lost bits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class BitTruncation(Effect):
    """The lowest bits of the converter's code are cut off on their way.

        DN' = 2^n floor((DN + 1/2) / 2^n)

    A bus that is too narrow, or firmware that shifts right and left again. Only every 2^n-th code
    is left, the mean falls by (2^n - 1)/2 DN, and the variance grows by (4^n - 1)/12 DN^2 over that
    of the rounded signal where its noise covers the step. Acts on the converter's whole codes; a
    demosaicer behind it fills codes in again.
    """

    name: ClassVar[str] = "bit_truncation"
    stage: ClassVar[Stage] = Stage.ADC
    position: ClassVar[int] = 20
    reference: ClassVar[str] = (
        "Widrow and Kollar, Quantization Noise (2008): truncation as rounding with an offset"
    )

    bits: float = parameter(
        2.0,
        unit="bit",
        minimum=0.0,
        maximum=8.0,
        identity=0.0,
        whole=True,
        doc="how many of the lowest bits are lost",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if self.bits == 0:
            return signal.replace(signal.value)
        step = float(2 ** int(self.bits))
        return signal.replace(step * dr.floor((signal.value + 0.5) / step))
