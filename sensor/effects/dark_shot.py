"""Dark-current shot noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

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
    same current: charge d t + s t n, n a standard normal number of the camera body, so that a
    pattern of standard deviation s t stays in the frames and grows with the exposure, as fixed
    offsets do not. A current whose pattern is skewed is the effect `dark_current`.
    """

    name: ClassVar[str] = "dark_shot"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 30
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equation (1) and Table I"

    current_e_per_s: float = parameter(
        20.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e5,
        identity=0.0,
        doc="dark current of a photosite at the sensor's temperature",
    )

    shown_e_per_s: float = parameter(
        0.0,
        unit="e-/s",
        minimum=-1e5,
        maximum=1e5,
        identity=0.0,
        doc="the part of its mean that the clamp leaves in the frames; below 0 it takes too much",
    )
    spread_e_per_s: float = parameter(
        0.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e5,
        identity=0.0,
        doc="standard deviation of the current over the photosites",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        dark_e = self.current_e_per_s * signal.shot.exposure_s
        shown_e = self.shown_e_per_s * signal.shot.exposure_s
        clamp_e = signal.clamp_e + dark_e - shown_e
        if self.spread_e_per_s == 0:
            return signal.pointwise(lambda mean: mean + dark_e, clamp_e=clamp_e)
        pattern_e = self.spread_e_per_s * signal.shot.exposure_s
        charge_e = dr.maximum(dark_e + pattern_e * stream.body.normal(*signal.shape[1:]), 0.0)
        return signal.pointwise(lambda mean, dark: mean + dark, charge_e, clamp_e=clamp_e)
