"""Differential nonlinearity of the converter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class AdcDnl(Effect):
    """The converter weighs the signal with bits that are not exact powers of two.

        w_i = 2^i + u sqrt(2^i) n_i,    scaled so that the top code stays where it is
        code c begins at T(c) = sum of w_i over its bits;    DN' = c - 1/2 + (DN - T(c)) / width(c)

    Bit i is made of 2^i unit elements that match to u; n_i is standard normal, drawn once for the
    camera body. Input is weighed from the heaviest bit down, as a successive-approximation or
    pipeline converter does. Codes with equally many trailing zeros are off by the same amount, the
    middle one by a standard deviation of u sqrt(2^bits - 1) codes: a comb that code widths which
    err independently do not have. The curve is applied before rounding, so that nothing is rounded
    twice.
    """

    name: ClassVar[str] = "adc_dnl"
    stage: ClassVar[Stage] = Stage.ADC
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "Pelgrom, Analog-to-Digital Conversion (2010), binary-weighted converters: DNL of the "
        "major carry; IEEE Std 1241-2010 for DNL"
    )

    unit_mismatch: float = parameter(
        0.03,
        unit="1",
        minimum=0.0,
        maximum=0.2,
        identity=0.0,
        doc="relative standard deviation of a unit element; 0.03 is half a code at 8 bits",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if self.unit_mismatch == 0:
            return signal.replace(signal.value)
        bits = signal.format.bits
        draws = np.asarray(stream.body.normal(bits).numpy()).ravel()
        weights, widths = converter(draws, self.unit_mismatch)
        tensor = signal.backend.tensor
        place = tensor(weights)
        rest, code = signal.value + 0.5, signal.value * 0.0
        for bit in reversed(range(bits)):
            on = rest >= place[bit]
            rest = dr.select(on, rest - place[bit], rest)
            code = dr.select(on, code + float(1 << bit), code)
        index = dr.uint32_array_t(type(code.array))(code.array)
        width = type(code)(dr.gather(type(code.array), tensor(widths).array, index), code.shape)
        return signal.replace(code - 0.5 + rest / dr.select(rest < 0, 1.0, width))


def converter(
    draws: NDArray[np.float32], mismatch: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Weights of the bits, lightest first, and widths of the codes, both in nominal codes.

    Where the weights are not monotonic, codes go missing: the input of a code ends where any
    higher one begins. A missing code has width 1, which nothing uses.
    """
    nominal = 2.0 ** np.arange(len(draws))
    weights = nominal + mismatch * np.sqrt(nominal) * draws
    weights *= nominal.sum() / weights.sum()
    begins = np.zeros(1)
    for weight in weights:
        begins = np.concatenate([begins, begins + weight])
    next_above = np.minimum.accumulate(begins[::-1])[::-1]
    widths = np.append(next_above[1:] - begins[:-1], 1.0)
    return weights, np.where(widths > 0, widths, 1.0)
