"""The histogram of codes: codes that are missing, favoured, or piled up at the ends."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.statistics.group import Group

LEAST_CODES = 8
"""From code 0, that are always looked at: darks of few codes have all of them in common then."""


def codes(group: Group) -> dict[str, float]:
    """Unevenness of the histogram against its own smooth course, by the place of a code's bits."""
    histogram = _histogram(group.codes)
    share = histogram / group.codes.size
    found = {
        "at zero": float(np.sqrt(share[0])),
        "at the top": float(np.sqrt(share[group.top_dn])) if len(share) > group.top_dn else 0.0,
    }
    for period in (2, 4, 8):
        by_place = np.array([share[k::period].sum() for k in range(period)])
        found[f"codes by place in {period}"] = float(
            np.sqrt(np.square(by_place - 1 / period).sum())
        )
    # what lies beyond the last code is no gap between codes
    end = max(LEAST_CODES, int(np.flatnonzero(histogram)[-1]) + 1)
    inner = histogram[1 : min(group.top_dn, end)]
    found["bumps of the histogram"] = 0.0
    around = np.convolve(inner, [0.5, 0.0, 0.5], mode="same")
    used = around > 50
    if used.sum() >= 4:
        bumps = np.log((inner[used] + 1.0) / (around[used] + 1.0))
        found["bumps of the histogram"] = float(np.sqrt(np.mean(np.square(np.clip(bumps, -2, 2)))))
    return found


def _histogram(codes: NDArray[Any]) -> NDArray[np.float64]:
    if codes.dtype == np.uint8:
        counts = cv2.calcHist([codes.reshape(1, -1)], [0], None, [256], [0, 256])
        return np.asarray(counts.ravel(), dtype=np.float64)
    return np.bincount(codes.ravel(), minlength=LEAST_CODES).astype(np.float64)
