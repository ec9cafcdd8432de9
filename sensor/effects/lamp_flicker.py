"""Lamp flicker."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage, parameter
from sensor.filament import has_filament
from sensor.frame_times import frame_starts_s
from sensor.image_plane import constant, per_frame
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class LampFlicker(Effect):
    """A lamp on the mains is brightest twice a cycle, and each shutter catches another part of it.

    The light is L(t) = 1 - depth + depth (pi/2) |sin(2 pi f t + phi)|, mean 1; depth 1 is a lamp
    without memory, a hot filament or phosphor smooths it. A frame that starts at t and exposes for
    T sees its mean over [t, t + T], in closed form: with u = 2 f t and n = 2 f T in half cycles,

        gain = 1 + depth (A(u + n) - A(u) - n) / n,   A(u) = floor u + (1 - cos(pi frac u)) / 2.

    The phase phi is that of the shot, and moves on by 2 f x interval from frame to frame. Where the
    exposure is a whole number of half cycles nothing is left, whatever the depth; otherwise the
    gains repeat with the beat of mains and frame rate. A random gain does neither. A shot in which
    every lamp has a filament (by its name) has `filament` times the depth.
    """

    name: ClassVar[str] = "lamp_flicker"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "IESNA Lighting Handbook, 9th edition (flicker of mains lamps); shutter mean in closed form"
    )

    depth: float = parameter(
        0.2,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        identity=0.0,
        doc="ripple relative to a rectified sine: filament 0.05 to 0.2, fluorescent 0.2 to 0.6",
    )
    mains_hz: float = parameter(
        50.0,
        unit="Hz",
        minimum=45.0,
        maximum=65.0,
        starts=(50.0, 60.0),
        doc="frequency of the mains; light has twice it",
    )

    filament: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        starts=(1.0, 0.2),
        doc="depth of a lamp with a filament relative to that of others: heat bridges the dark",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        half_cycles = 2.0 * self.mains_hz * signal.shot.exposure_s
        if signal.shot.dark or half_cycles == 0.0:
            return signal.replace(signal.value)
        # Whole half cycles hold their mean exactly; only the rest depends on the phase.
        rest = constant(signal, half_cycles % 1.0)
        relative = self.filament if has_filament(signal.shot) else 1.0
        scale = constant(signal, self.depth * relative / half_cycles)
        starts = np.mod(2.0 * self.mains_hz * frame_starts_s(signal), 1.0)
        begin = per_frame(signal, starts) + stream.whole_shot.uniform(1, 1, 1, use="phase")
        end = begin + rest
        whole = dr.floor(end) - dr.floor(begin)
        lobes = dr.cos(math.pi * (begin - dr.floor(begin))) - dr.cos(
            math.pi * (end - dr.floor(end))
        )
        gain = 1.0 + scale * (whole + 0.5 * lobes - rest)
        dr.eval(gain)  # F numbers: computed once, not once for each pixel
        return signal.replace(signal.value * gain)
