"""Dark-current shot noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class DarkShot(Effect):
    """Thermal electrons collect during the exposure; their mean is clamped off, not their noise.

    Mean charge d t joins the light before the shot noise is drawn, and the optical-black clamp
    takes d t off again: variance d t, no change of the mean. Dark current that the clamp does not
    follow is the effect `dark_current`.
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

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        dark_e = self.current_e_per_s * signal.shot.exposure_s
        return signal.replace(signal.value + dark_e, clamp_e=signal.clamp_e + dark_e)
