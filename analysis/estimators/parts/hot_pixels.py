"""Hot pixels: brighter than their neighbours in every dark frame, and so no noise in time."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from sensor.frames import Frames

SIGMAS = 6.0
"""Excess over the median, in robust SDs of the frame: one in 10^9 of Gaussian pixels."""

LEAST_DN = 2.0
"""Least excess in DN, so that rounding of a clipped or very quiet frame makes none."""

CHUNK_SAMPLES = 1 << 24


def count_hot_pixels(frames: Frames) -> int:
    """Number of hot pixels in a stack of dark frames.

    A pixel is hot where its least value over the stack exceeds the median of all pixels' least
    values by 6 robust SDs and 2 DN. A demosaic spreads one pixel over its neighbours, so touching
    ones count once in demosaiced frames.
    """
    step = max(1, CHUNK_SAMPLES // frames.dn[0].size)
    least = frames.dn[:step].min(axis=0)
    for start in range(step, frames.count, step):
        least = np.minimum(least, frames.dn[start : start + step].min(axis=0))
    median = np.median(least, axis=(0, 1))
    robust_sd = 1.4826 * np.median(np.abs(least - median), axis=(0, 1))
    hot = least > median + np.maximum(SIGMAS * robust_sd, LEAST_DN)
    if frames.demosaiced:
        _, groups = ndimage.label(hot.any(axis=2), structure=np.ones((3, 3)))
        return int(groups)
    return int(np.count_nonzero(hot))
