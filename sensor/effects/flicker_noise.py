"""Flicker noise."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass
from functools import reduce
from typing import Any, ClassVar

import drjit as dr

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.neighbours import run_length
from sensor.planes import Planes
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.whole_numbers import whole_number

_WHITE_SHARE = 1.0 / math.log(2.0)
"""Variance of the white term in octaves: makes f S(f) at half the pixel rate what it is below."""

_COARSE = 4
"""Holds of 2^4 pixels and more are summed once per 16 pixels, as they change no faster."""


@dataclass(frozen=True, kw_only=True)
class FlickerNoise(Effect):
    """The output transistor's traps hold and release charge at all rates: noise of spectrum 1/f.

        e(t) += s sum_j h_j(t),    t = y W + x,    two-sided spectrum S(f) = s^2 / (2 ln 2 f)

    h_j is a standard normal number held for 2^j pixels of the read-out and then drawn anew, the
    first hold cut at random: one process per octave from the pixel rate down to one frame, each of
    variance s^2. Slower parts are taken off by the clamp, so that frames are independent. Equal
    power in every octave makes the variance of means over m pixels fall as the logarithm of m,
    where that of independent noise falls as 1/m. The sum of holds departs from 1/f by at most 14 %
    (a ripple with a period of one octave), its fitted slope from -1 by 0.01.
    """

    name: ClassVar[str] = "flicker_noise"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 25
    reference: ClassVar[str] = (
        "Voss and Clarke, '1/f noise' in music, J. Acoust. Soc. Am. 63, 258 (1978), for the sum "
        "of held numbers; Janesick, Scientific Charge-Coupled Devices (2001), chapter 6"
    )

    sigma_e: float = parameter(
        15.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        doc="standard deviation of all octaves together",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        height, width = signal.shape[1:3]
        pixels = height * width
        octaves = max(_COARSE + 1, math.ceil(math.log2(pixels)))
        counts = [(pixels >> j) + 3 for j in range(1, octaves)]
        drawn = -(-sum(counts) // 4) * 4  # as they come: none is cut off and none moved
        numbers = stream.normal(drawn, use="held").array
        cuts = stream.uniform(2, use="cuts").array
        dr.eval(numbers, cuts)
        flat = type(numbers)
        index = dr.uint32_array_t(flat)

        # one random cut per frame serves all octaves, as its low bits are random for the short
        # holds and its high bits for the long ones; it is drawn as two numbers of 24 bits
        batch, cells = len(signal.frames), (pixels >> _COARSE) + 2
        lane = dr.arange(index, batch * cells)
        frame = lane // cells
        high = whole_number(dr.gather(flat, cuts, frame * 2 + 1) * float(1 << (octaves - _COARSE)))
        coarse: Any = 0.0
        for j in range(_COARSE, octaves):
            hold = ((lane - frame * cells + high) >> (j - _COARSE)) - (high >> (j - _COARSE))
            coarse = coarse + dr.gather(flat, numbers, frame * drawn + sum(counts[: j - 1]) + hold)
        dr.eval(coarse)

        length = run_length(signal.backend.arrays, width)  # as the white numbers come
        lane = dr.arange(index, batch * pixels // length)
        frame = lane // (pixels // length)
        low = whole_number(dr.gather(flat, cuts, frame * 2) * float(1 << _COARSE))
        place = (lane - frame * (pixels // length)) * length + low
        octave = [
            _held(numbers, frame * drawn + sum(counts[: j - 1]) - (low >> j), place, j, length)
            for j in range(1, _COARSE)
        ]
        octave.append(_held(coarse, frame * cells, place, _COARSE, length))
        fine = tuple(reduce(operator.add, values) for values in zip(*octave, strict=True))
        slow = Planes(colours=(fine,), shape=(batch, height, width), arrays=signal.backend.arrays)
        share, whole = math.sqrt(_WHITE_SHARE), math.sqrt(octaves - 1 + _WHITE_SHARE)
        strength = Colours.of(self.sigma_e).map(lambda sigma: sigma / whole)
        return signal.pointwise(
            lambda e, sigma, held, white: e + sigma * (share * white + held),
            strength,
            slow,
            stream.noise(signal, use="white"),
        )


def _held(numbers: Any, before: Any, place: Any, octave: int, length: int) -> list[Any]:
    """Numbers that are held for 2^octave places each, at so many places in a row.

    Args:
        numbers: where they are.
        before: index of the one that is held at place 0.
        place: the first place.
        octave, length: as told.
    """
    hold = 1 << octave
    first, since = before + (place >> octave), place & (hold - 1)
    seen = [
        dr.gather(type(numbers), numbers, first + k) for k in range((length + hold - 2) // hold + 1)
    ]
    held = []
    for k in range(length):
        least, most = k // hold, (k + hold - 1) // hold
        value = seen[least]
        if most > least:
            value = dr.select(since >= most * hold - k, seen[most], value)
        held.append(value)
    return held
