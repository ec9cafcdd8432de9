"""Lamp warm-up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sensor.effect import Effect, Stage, parameter, switch
from sensor.filament import has_filament
from sensor.frame_times import frame_starts_s
from sensor.image_plane import per_frame
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class LampDrift(Effect):
    """A lamp that was switched on approaches its lasting brightness exponentially.

    The light is L(t) = 1 + change (1 - r exp(-t / tau)) from the start of each shot; a frame sees
    its mean over the exposure T:

        gain = 1 + change (1 - r exp(-t / tau) (1 - exp(-T / tau)) tau / T).

    Of a lamp that is switched on with each shot r is 1, and its light nominal at the start. Of one
    that has been on for an unknown time before, tau in the mean, r is drawn for each shot, evenly
    between 0 and 1. A time constant far beyond the length of the shot makes a straight line.
    Differences between frames at equal distance fall by the same factor exp(-interval / tau) each,
    all in one direction; random gains of equal variance change direction. A shot in which every
    lamp has a filament (by its name) has `filament` times the change: a gas that warms up may
    brighten where a wire dims.
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

    filament: float = parameter(
        1.0,
        unit="1",
        minimum=-10.0,
        maximum=10.0,
        starts=(1.0, -1.0),
        doc="change of a lamp with a filament relative to that of others",
    )
    on_before: float = switch(
        0.0,
        starts=(0.0, 1.0),
        doc="1 where a lamp has been on for any time before a shot, 0 where it starts with each",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.shot.dark:
            return signal.replace(signal.value)
        tau_s, exposure_s = self.time_constant_s, signal.shot.exposure_s
        turns = exposure_s / tau_s
        within = -math.expm1(-turns) / turns if turns > 0 else 1.0
        missing = np.exp(-frame_starts_s(signal) / tau_s) * within
        if self.on_before:
            still_to_come = stream.whole_shot.uniform(1, use="on before").numpy()
            missing *= float(np.ravel(still_to_come)[0])
        change = self.change * (self.filament if has_filament(signal.shot) else 1.0)
        return signal.replace(signal.value * per_frame(signal, 1.0 + change * (1.0 - missing)))
