"""Electrical interference."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Interference(Effect):
    """A clock or a switching supply couples into the video line: bars that wander over the frame.

        e(k, y, x) += A sin(2 pi ((y (W + B) + x) / P + k d + j u_k + w (n_1 + ... + n_k) + phi))

    y (W + B) + x counts pixels in the order they are read, and B those that pass while a line is
    blanked; P is the period on that count and d the part of a cycle by which the pattern moves
    between frames. phi is uniform, once for the shot; u_k is uniform in each frame, for a source
    that does not keep time (j = 1) rather than one that does (j = 0), and n_k is standard normal,
    for one that runs freely: the phases of frames m apart then agree by exp(-2 pi^2 w^2 m). Adds
    A^2 / 2 to the temporal variance, all of it at one frequency: the power of the read-out series
    at 1 / P is A^2 N / 4 for N pixels, where independent noise of the same variance has A^2 / 2.
    """

    name: ClassVar[str] = "interference"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 40
    reference: ClassVar[str] = (
        "periodic noise in the spectrograms of EMVA 1288 release 4; "
        "Janesick, Scientific Charge-Coupled Devices (2001), chapter 7: system noise pick-up"
    )

    amplitude_e: float = parameter(
        15.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        doc="amplitude of the sinusoid",
    )
    period_px: float = parameter(
        23.7,
        unit="px",
        minimum=2.0,
        maximum=1e6,
        doc="period along the read-out; twice the width and more makes horizontal bars",
    )
    drift_cycles_per_frame: float = parameter(
        0.137,
        unit="cycles/frame",
        minimum=-0.5,
        maximum=0.5,
        doc="how far the pattern moves from one frame to the next",
    )

    blanking_px: float = parameter(
        0.0,
        unit="px",
        minimum=0.0,
        maximum=1e6,
        doc="pixels that pass between two lines; it turns the wave from row to row",
    )
    jitter_cycles: float = parameter(
        0.0,
        unit="cycles",
        minimum=0.0,
        maximum=1.0,
        starts=(0.0, 1.0),
        doc="width of what is random about the phase of a frame; 1 is any phase",
    )
    walk_cycles: float = parameter(
        0.0,
        unit="cycles",
        minimum=0.0,
        maximum=0.5,
        doc="standard deviation of a step that the phase makes besides from frame to frame",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        height, width = signal.shape[1:3]
        tensor = signal.backend.tensor
        # whole cycles are taken off in double precision: there may be 1e5 of them in a frame
        columns = tensor((np.arange(width) / self.period_px % 1.0)[None, None, :])
        line = (width + self.blanking_px) / self.period_px
        rows = tensor((np.arange(height) * line % 1.0)[None, :, None])
        frame = np.array(signal.frames, dtype=np.float64)
        frames = tensor((frame * self.drift_cycles_per_frame % 1.0)[:, None, None])
        start = stream.whole_shot.uniform(1, 1)
        if self.jitter_cycles > 0:
            start = start + self.jitter_cycles * stream.uniform(1, 1, use="jitter")
        if self.walk_cycles > 0:
            start = start + tensor(self._walked(stream)[:, None, None])
        wave = dr.sin(2.0 * math.pi * (columns + rows + (frames + start)))
        return signal.replace(signal.value + signal.by_colour(self.amplitude_e) * wave)

    def _walked(self, stream: Stream) -> NDArray[np.float64]:
        """How far the phase has walked in each frame, in cycles less whole ones, (F,)."""
        from_the_first = dataclasses.replace(stream, frames=range(stream.frames.stop))
        steps = np.asarray(from_the_first.normal(1, use="walk").numpy(), dtype=np.float64).ravel()
        return self.walk_cycles * np.cumsum(steps)[stream.frames.start :] % 1.0
