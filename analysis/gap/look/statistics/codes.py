"""The histogram of codes: codes that are missing, favoured, or piled up at the ends."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.statistics.group import Figures, Floats, Group, safe_ratio

LEAST_CODES = 8
"""From code 0, that are always looked at: darks of few codes have all of them in common then."""

LEAST_COUNT = 50
"""Samples that a code's neighbours have on average where its own number begins to be compared with
theirs; with twice as many it counts in full."""

FEWEST = 4.0
"""Codes of which a mean is taken, of fewer their sum over as many."""

REACH = 4
"""Codes to either side among which a frequent one is looked for: curves leave out up to three."""


def codes(group: Group) -> Figures:
    """Unevenness of the histogram against its own smooth course, by the place of a code's bits."""
    histogram = _histograms(group.codes)
    share = histogram / (group.frames * group.pixels)
    top = share[:, group.top_dn] if share.shape[1] > group.top_dn else np.zeros(len(share))
    found = {"at zero": np.sqrt(share[:, 0]), "at the top": np.sqrt(top)}
    for period in (2, 4, 8):
        by_place = share.reshape(len(share), -1, period).sum(axis=1)
        found[f"codes by place in {period}"] = np.sqrt(np.square(by_place - 1 / period).sum(axis=1))
    found["bumps of the histogram"] = _bumps(histogram, group.top_dn)
    found["empty codes"] = _empty(histogram)
    return found


def _bumps(histogram: Floats, top_dn: int) -> Floats:
    """Root mean square of the logarithm of a code's number over its neighbours', (k,).

    Codes 0 and the top are clipped ones; what lies beyond the last code is no gap between codes.
    """
    code = np.arange(histogram.shape[1])
    last = np.where(histogram > 0, code, 0).max(axis=1)
    end = np.minimum(np.maximum(LEAST_CODES, last + 1), top_dn)
    within = (code > 0) & (code < end[:, None])
    inner = np.where(within, histogram, 0.0)
    around = np.zeros_like(inner)
    around[:, 1:-1] = (inner[:, :-2] + inner[:, 2:]) / 2
    # a code that began to count all at once would make darks of few codes jump
    weight = np.where(within, np.clip(around / LEAST_COUNT - 1.0, 0.0, 1.0), 0.0)
    bumps = np.clip(np.log((inner + 1.0) / (around + 1.0)), -2, 2)
    count = np.maximum(weight.sum(axis=1), FEWEST)
    return np.asarray(np.sqrt((weight * np.square(bumps)).sum(axis=1) / count))


def _empty(histogram: Floats) -> Floats:
    """Root of the share of codes that never occur, of those between frequent ones, (k,)."""
    between = between_frequent(histogram)
    empty = (between & (histogram == 0)).sum(axis=1)
    return np.sqrt(safe_ratio(empty.astype(np.float64), between.sum(axis=1)))


def between_frequent(histogram: NDArray[Any]) -> NDArray[np.bool_]:
    """Which codes lie between frequent ones, (k, codes)."""
    frequent = np.pad(histogram > LEAST_COUNT, ((0, 0), (REACH, REACH)))
    within = np.lib.stride_tricks.sliding_window_view(frequent, 2 * REACH + 1, axis=1)
    below, above = within[..., :REACH].any(axis=2), within[..., REACH + 1 :].any(axis=2)
    return np.asarray(below & above)


def _histograms(codes: NDArray[Any]) -> Floats:
    """Samples of each code, (k, codes), a multiple of 8 of them and one beyond the largest."""
    if codes.dtype == np.uint8:
        rows = codes.reshape(len(codes), 1, -1)
        counts = [cv2.calcHist([one], [0], None, [256], [0, 256]).ravel() for one in rows]
    else:
        length = max(LEAST_CODES, int(codes.max()) + 1)
        flat = codes.reshape(len(codes), -1)
        counts = [np.bincount(one, minlength=-(-length // 8) * 8) for one in flat]
    return np.array(counts, dtype=np.float64)
