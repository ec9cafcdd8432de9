"""Standard error of the mean of a map whose neighbours are alike, as after a demosaic."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

REACH_PX = 2
"""Neighbours farther apart than this share no sample of a bilinear demosaic's 3 x 3 kernel."""


def se_of_mean(values: NDArray[np.float64]) -> float:
    """Standard error of the mean of a map (h, w), from the spread of the map itself.

    Neighbours up to `REACH_PX` apart may be correlated: their covariances are summed. The means
    of the four sites of a 2 x 2 mosaic differ for good, not by chance, and are taken off first.
    The sum is held at or above the variance of uncorrelated pixels: noise that a demosaic spreads
    is never less than independent.
    """
    h, w = values.shape
    d = values.astype(np.float64)
    for i in range(2):
        for j in range(2):
            site = d[i::2, j::2]
            site -= site.mean()
    white = float(np.mean(d * d))
    total = 0.0
    for i in range(-REACH_PX, REACH_PX + 1):
        for j in range(REACH_PX + 1):
            if j == 0 and i <= 0:
                continue
            a = d[max(i, 0) : h + min(i, 0), j:]
            b = d[max(-i, 0) : h + min(-i, 0), : w - j]
            total += 2.0 * float(np.vdot(a, b)) / d.size
    return float(np.sqrt(max(white + total, white) / d.size))
