"""Response that bends towards full well."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Nonlinearity(Effect):
    """A filling photosite loses potential, and so collects and converts each electron less well.

    Q' = Q (1 - a x - b x^2), x = Q / full well, at most 1.

    Consequence: fluctuations shrink by the local slope, means by the mean one: temporal variance
    m (1 - 2 a x - 3 b x^2)^2 at a mean of m (1 - a x - b x^2), so the photon transfer curve bends
    down while the noise stays uncorrelated. Less light of the same mean keeps variance = mean.
    """

    name: ClassVar[str] = "nonlinearity"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 65
    reference: ClassVar[str] = (
        "Janesick, Photon Transfer, SPIE 2007, chapter on nonlinearity; EMVA 1288 release 4, "
        "linearity error"
    )

    quadratic_ratio: float = parameter(
        0.03,
        unit="1",
        minimum=-0.1,
        maximum=0.1,
        identity=0.0,
        doc="share lost at full well by the quadratic term",
    )
    cubic_ratio: float = parameter(
        0.03,
        unit="1",
        minimum=-0.1,
        maximum=0.1,
        identity=0.0,
        doc="share lost at full well by the cubic term",
    )
    full_well_e: float = parameter(
        16_000.0,
        unit="e-",
        minimum=1000.0,
        maximum=1e6,
        doc="charge at which the two shares are stated",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        x = dr.minimum(signal.value * (1 / self.full_well_e), 1.0)
        share = x * (self.quadratic_ratio + self.cubic_ratio * x)
        return signal.replace(signal.value * (1.0 - share))
