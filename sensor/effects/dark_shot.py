"""Dark-current shot noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class DarkShot(Effect):
    """Thermal electrons collect during the exposure; their mean is clamped off, not their noise.

    Mean charge d t joins the light before the shot noise is drawn, and the optical-black clamp
    takes d t off again: variance d t, no change of the mean. A clamp that takes off less, or more,
    leaves a mean that grows with the exposure by gain x shown x t. No two photosites have quite the
    same current: charge d t + s t l, where l is a number of the camera body of mean 0 and variance
    1, so that a pattern of standard deviation s t stays in the frames and grows with the exposure,
    as fixed offsets do not. Where l is standard normal it has no skewness; currents of real silicon
    are nearly log-normal, and with n standard normal and v = ln(1 + u^2)

        l = (exp(sqrt(v) n - v / 2) - 1) / u

    has a skewness of 3 u + u^3. A current that nobody knows of is the effect `dark_current`.
    """

    name: ClassVar[str] = "dark_shot"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 30
    base: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "Irie et al., equation (1) and Table I; for the pattern Baer, A model for dark current "
        "characterization and simulation, Proc. SPIE 6068, 2006"
    )

    current_e_per_s: float = parameter(
        20.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e6,
        identity=0.0,
        doc="dark current of a photosite at the sensor's temperature",
    )

    shown_e_per_s: float = parameter(
        0.0,
        unit="e-/s",
        minimum=-1e6,
        maximum=1e6,
        identity=0.0,
        doc="the part of its mean that the clamp leaves in the frames; below 0 it takes too much",
    )
    spread_e_per_s: float = parameter(
        0.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e6,
        identity=0.0,
        doc="standard deviation of the current over the photosites",
    )
    uneven: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=3.0,
        doc="u of the law that the current follows over the photosites: 0 normal, else log-normal",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        dark_e = self.current_e_per_s * signal.shot.exposure_s
        shown_e = self.shown_e_per_s * signal.shot.exposure_s
        clamp_e = signal.clamp_e + dark_e - shown_e
        if self.spread_e_per_s == 0:
            return signal.pointwise(lambda mean, dark: mean + dark, dark_e, clamp_e=clamp_e)
        pattern_e = self.spread_e_per_s * signal.shot.exposure_s
        charge_e = dr.maximum(dark_e + pattern_e * self.pattern(stream, *signal.shape[1:]), 0.0)
        return signal.pointwise(lambda mean, dark: mean + dark, charge_e, clamp_e=clamp_e)

    def pattern(self, stream: Stream, height: int, width: int) -> Any:
        """How far the current of each photosite is from the mean, over the spread: a tensor."""
        normal = stream.body.normal(height, width)
        if self.uneven == 0:
            return normal
        v = math.log1p(self.uneven**2)
        return (dr.exp(math.sqrt(v) * normal - v / 2) - 1.0) / self.uneven
