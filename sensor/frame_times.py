"""When the frames of a shot are taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sensor.signal import Signal

USUAL_INTERVAL_S = 1 / 15
"""Between frames where a shot does not say: the fastest native mode of an IIDC camera in RGB8."""


def frame_starts_s(signal: Signal) -> NDArray[np.float64]:
    """When each frame's exposure begins, in s after that of frame 0: (F,).

    A shot without an interval is taken at 15 frames a second, or slower where it exposes longer.
    """
    shot = signal.shot
    interval_s = shot.interval_s or max(USUAL_INTERVAL_S, shot.exposure_s)
    return np.arange(signal.frames.start, signal.frames.stop, dtype=np.float64) * interval_s
