"""Lamp warm-up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sensor.effect import Effect, Stage, parameter
from sensor.frame_times import frame_starts_s
from sensor.image_plane import per_frame
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class LampDrift(Effect):
    """A lamp that was just switched on approaches its lasting brightness exponentially.

    The light is L(t) = 1 + change (1 - exp(-t / tau)) from the start of each shot, where it is
    nominal; a frame sees its mean over the exposure T:

        gain = 1 + change (1 - exp(-t / tau) (1 - exp(-T / tau)) tau / T).

    A time constant far beyond the length of the shot makes a straight line. Differences between
    frames at equal distance fall by the same factor exp(-interval / tau) each, all in one
    direction; random gains of equal variance change direction.
    """

    name: ClassVar[str] = "lamp_drift"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 20
    reference: ClassVar[str] = "thermal settling of first order; EMVA 1288 release 4, stable source"

    change: float = parameter(
        0.05,
        unit="1",
        minimum=-0.5,
        maximum=0.5,
        identity=0.0,
        starts=(0.05, -0.02),
        doc="lasting brightness minus that at the start of the shot, relative to the latter",
    )
    time_constant_s: float = parameter(
        10.0, unit="s", minimum=0.1, maximum=3600.0, doc="time constant of the warm-up"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.shot.dark:
            return signal.replace(signal.value)
        tau_s, exposure_s = self.time_constant_s, signal.shot.exposure_s
        spent = exposure_s / tau_s
        within = -math.expm1(-spent) / spent if spent > 0 else 1.0
        missing = np.exp(-frame_starts_s(signal) / tau_s) * within
        return signal.replace(signal.value * per_frame(signal, 1.0 + self.change * (1.0 - missing)))
