"""What tests of light share: laws as figures with their errors, and impostors that break them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.effects.read_noise import ReadNoise
from sensor.signal import Signal
from sensor.stream import Stream
from tests.effects_bench import (
    READ_E,
    Array,
)
from tests.harness import worst_z

Law = tuple[object, object, object]
HEIGHT, WIDTH = 64, 96
Y, X = np.mgrid[:HEIGHT, :WIDTH] - np.array([HEIGHT - 1, WIDTH - 1])[:, None, None] / 2
CORNER_PX = math.hypot(HEIGHT, WIDTH) / 2


def obeys(law: Law) -> bool:
    worst, limit = worst_z(*law)
    return worst <= limit


def noise_of(variance_e2: float) -> ReadNoise:
    """Independent noise: that of the bench and so much variance more."""
    return ReadNoise(reset_e=0.0, thermal_e=math.hypot(READ_E, math.sqrt(variance_e2)), other_e=0.0)


def frame_means(frames: Array) -> tuple[Array, float]:
    """Mean of each frame, and its standard error from the noise of the pixels."""
    noise = np.diff(frames - frames.mean((1, 2), keepdims=True), axis=0).var() / 2
    return frames.mean((1, 2)), math.sqrt(noise / frames[0].size)


@dataclass(frozen=True, kw_only=True)
class RandomGain(Effect):
    """The impostor of everything that changes in time: each frame has its own, independent gain."""

    name: ClassVar[str] = "random_gain"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 11
    reference: ClassVar[str] = "none: an impostor"
    sigma: float = parameter(0.0, unit="1", minimum=0.0, maximum=1.0, doc="standard deviation")

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value * (1.0 + self.sigma * stream.normal(1, 1, 1)))


@dataclass(frozen=True, kw_only=True)
class GainAfterShotNoise(Effect):
    """The impostor of another lamp: amplifiers of another gain by colour."""

    name: ClassVar[str] = "gain_after_shot_noise"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 1
    reference: ClassVar[str] = "none: an impostor"
    gain: float | Colours = parameter(
        1.0, unit="1", minimum=0.0, maximum=9.0, per_colour=True, doc="gain"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value * signal.by_colour(self.gain))


@dataclass(frozen=True, kw_only=True)
class Offset(Effect):
    """The impostor of light in the dark: a black level."""

    name: ClassVar[str] = "offset"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 1
    reference: ClassVar[str] = "none: an impostor"
    level_e: float = parameter(0.0, unit="e-", minimum=0.0, maximum=1e4, doc="offset")

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value + self.level_e)
