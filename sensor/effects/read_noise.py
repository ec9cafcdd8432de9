"""Read noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ReadNoise(Effect):
    """Reset, thermal and other noise of the readout: independent, Gaussian, in every pixel anew.

    sigma^2 = reset^2 + thermal^2 + other^2. The three cannot be told apart in frames, so their sum
    is drawn once. The clamp takes the mean of optically black pixels off, which have the same
    noise: n of them leave sigma/sqrt(n) that all pixels of a frame share.
    """

    name: ClassVar[str] = "read_noise"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 20
    base: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "Irie et al., equation (1) and Table I: N_read = N_R + N_therm + N_other"
    )

    reset_e: float | Colours = parameter(
        8.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        per_colour=True,
        doc="reset (kTC) noise",
    )
    thermal_e: float | Colours = parameter(
        10.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        per_colour=True,
        doc="thermal noise of the output stage",
    )
    other_e: float | Colours = parameter(
        4.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        per_colour=True,
        doc="flicker noise, transistor dark currents and the rest",
    )
    clamp_e: float = parameter(
        0.0,
        unit="e-",
        minimum=0.0,
        maximum=100.0,
        identity=0.0,
        doc="what a frame's pixels share, because its clamp averages finitely many black ones",
    )

    @property
    def sigma_e(self) -> Colours:
        """Standard deviation of all three together, by colour."""
        reset, thermal, other = (
            Colours.of(part) for part in (self.reset_e, self.thermal_e, self.other_e)
        )
        return reset.map(math.hypot, thermal).map(math.hypot, other)

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        noise = stream.noise(signal)
        if self.clamp_e == 0:
            return signal.pointwise(lambda e, sigma, n: e + sigma * n, self.sigma_e, noise)
        shared = self.clamp_e * stream.normal(1, 1, use="clamp")
        return signal.pointwise(
            lambda e, sigma, n, shift: e + sigma * n + shift, self.sigma_e, noise, shared
        )
