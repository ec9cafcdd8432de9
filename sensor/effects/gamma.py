"""Gamma: a tone curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.limits import at_least
from sensor.powers import power
from sensor.signal import Signal
from sensor.stream import Stream

_TOE = 0.018
"""Part of the range up to which the curve is a straight line, as in ITU-R BT.709."""

_NOTHING = 1e-12
"""Part of the range that is none: a power needs a number above 0."""


@dataclass(frozen=True, kw_only=True)
class Gamma(Effect):
    """The camera bends its output for the eye and the screen.

        DN' = o + R x^g,    x = (DN - o) / R,    R = top - o;    a chord below x = 0.018

    where o is the black level. The chord keeps the slope finite there and lets noise below it pass.
    Where there is none, what is below black is bent the other way, and noise there grows without
    bound as x^(g-1). A program that bends whole pictures knows of no black level: o is code 0, the
    black level is bent as well, and there is no chord. Noise passes with the slope of the curve,
    sigma' = g x^(g-1) sigma, so that the photon transfer curve becomes
    variance = g^2 x^(2g-2) (k x + r^2) and is no straight line any more; a gain leaves it one.
    """

    name: ClassVar[str] = "gamma"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 50
    reference: ClassVar[str] = "ITU-R BT.709-6, item 1.2, with the exponent free"

    exponent: float = parameter(
        0.8,
        unit="1",
        minimum=0.3,
        maximum=3.0,
        identity=1.0,
        doc="power of the relative signal; 0.45 is full video gamma, 1 is linear",
    )
    about_black: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=2.0,
        whole=True,
        starts=(1.0, 0.0, 2.0),
        doc="where the curve begins: 1 at the black level with a chord, 2 without, 0 at code 0",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if self.exponent == 1:
            return signal.replace(signal.value)
        origin = signal.format.black_dn if self.about_black else 0.0
        span = signal.format.top_dn - origin
        # figures are data, so that a new value compiles nothing
        number = dr.array_t(signal.backend.arrays.TensorXf)
        exponent = dr.opaque(number, self.exponent)
        chord = self.about_black == 1
        toe = _TOE if chord else 0.0
        slope = dr.opaque(number, _TOE ** (self.exponent - 1.0) if chord else 0.0)

        def bent(value: Any) -> Any:
            x = (value - origin) * (1.0 / span)
            if self.about_black == 2:
                size = power(at_least(dr.abs(x), _NOTHING), exponent)
                return origin + span * dr.select(x < 0.0, -size, size)
            curve = power(at_least(x, toe), exponent)
            return origin + span * dr.select(x > toe, curve, x * slope)

        return signal.pointwise(bent)
