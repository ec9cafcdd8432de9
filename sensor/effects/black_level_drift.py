"""Drift of the black level."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream

_FORGOTTEN = 1e-4
"""Weight below which the memory of an earlier frame is cut off."""


@dataclass(frozen=True, kw_only=True)
class BlackLevelDrift(Effect):
    """The clamp follows black slowly and noisily: its level wanders down a frame and along a shot.

        e(k, y, x) += s_r u(k, y) + s_f v(k)
        u(y + 1) = rho u(y) + sqrt(1 - rho^2) n,    rho = exp(-1 / L);  v(k) alike, from frame to
        frame

    A random walk that the clamp's loop pulls back to nominal, so its spread stays bounded. Means
    of rows d apart keep a covariance of s_r^2 exp(-d / L_r), and means of frames one of
    s_f^2 exp(-d / L_f); row noise of the same variance has none. Every frame's wander down the
    rows starts anew, because the clamp is set again in the vertical blanking.
    """

    name: ClassVar[str] = "black_level_drift"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 50
    reference: ClassVar[str] = (
        "Uhlenbeck and Ornstein, Phys. Rev. 36, 823 (1930), for the walk that is pulled back; "
        "Janesick, Scientific Charge-Coupled Devices (2001), chapter 6, for the clamp"
    )

    row_sigma_e: float = parameter(
        6.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        starts=(6.0, 0.0),
        doc="standard deviation of the wander down the rows",
    )
    row_length: float = parameter(
        40.0,
        unit="rows",
        minimum=1.0,
        maximum=1e4,
        doc="rows in which that wander forgets all but 1/e",
    )
    frame_sigma_e: float = parameter(
        8.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        starts=(8.0, 0.0),
        doc="standard deviation of the wander along the shot",
    )
    frame_length: float = parameter(
        20.0,
        unit="frames",
        minimum=1.0,
        maximum=200.0,
        doc="frames in which that wander forgets all but 1/e",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        height = signal.shape[1]
        rows = np.asarray(stream.normal(height, use="rows").numpy()).reshape(-1, height)
        offset = self.row_sigma_e * _down_the_rows(rows, self.row_length)
        offset += self.frame_sigma_e * self._along_the_shot(stream)[:, None]
        return signal.replace(signal.value + signal.backend.tensor(offset[:, :, None]))

    def _along_the_shot(self, stream: Stream) -> NDArray[np.float64]:
        """One standard normal figure per frame, from the numbers of the frames before it too."""
        earlier = math.ceil(-self.frame_length * math.log(_FORGOTTEN))
        frames = range(stream.frames.start - earlier, stream.frames.stop)
        longer = dataclasses.replace(stream, frames=frames)
        numbers = np.asarray(longer.normal(1, use="frames").numpy(), dtype=np.float64).ravel()
        weights = np.exp(-np.arange(earlier + 1) / self.frame_length)
        return np.convolve(numbers, weights / np.linalg.norm(weights), mode="valid")


def _down_the_rows(numbers: NDArray[np.float32], length: float) -> NDArray[np.float64]:
    """The walk of unit variance that independent numbers (F, H) drive down the rows."""
    rho = math.exp(-1.0 / length)
    driven = numbers.astype(np.float64)
    driven[:, 1:] *= math.sqrt(1.0 - rho * rho)
    return np.asarray(lfilter([1.0], [1.0, -rho], driven, axis=1))
