"""When the frames of a shot are taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sensor.protocol import Shot
from sensor.signal import Signal

USUAL_INTERVAL_S = 1 / 15
"""Between frames where a shot does not say: the fastest native mode of an IIDC camera in RGB8."""


def interval_of(shot: Shot) -> float:
    """From the start of a frame to that of the next in s.

    A shot that does not say is taken at 15 frames a second, or slower where it exposes longer.
    """
    return shot.interval_s or max(USUAL_INTERVAL_S, shot.exposure_s)


def frame_starts_s(signal: Signal) -> NDArray[np.float64]:
    """When each frame's exposure begins, in s after that of frame 0: (F,)."""
    places = np.arange(signal.frames.start, signal.frames.stop, dtype=np.float64)
    return places * interval_of(signal.shot)
