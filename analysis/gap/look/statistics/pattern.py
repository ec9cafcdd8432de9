"""The fixed pattern: what stays from frame to frame, by two halves of a group.

Products of the halves have no bias from noise in time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.statistics.group import Array, Figures, Floats, Group, safe_ratio

LAGS = ((0, 1), (1, 0), (1, 1), (0, 2), (0, 4), (4, 0))


def pattern(group: Group) -> Figures:
    """Variance of the pattern over the square of its mean in light, in DN^2 in the dark.

    Where patches of a chart meet, light that was traced with a finite number of paths is rougher
    than any pattern, and light of the real chart is not: edges are left out.
    """
    k = len(group.codes)
    a, b = group.crossed_halves if group.lit else group.halves
    product = (a * b).reshape(k, -1)
    cap = (_cap_in_light(product) if group.lit else _cap_in_the_dark(product))[:, None]
    capped = np.clip(product, -cap, cap)
    if not group.lit:
        return {"pattern variance": capped.mean(axis=1, dtype=np.float64)}
    even = group.away_from_edges[:, 1:-1, 1:-1].reshape(k, -1)
    square = np.square(group.mean[:, 1:-1, 1:-1]).reshape(k, -1)
    variance, light = (np.asarray(np.vecdot(even, one), np.float64) for one in (capped, square))
    return {"pattern variance": safe_ratio(variance, np.maximum(light, even.sum(axis=1)) * 1e-4)}


LEAST_OF_A_LINE = 0.25
"""Part of a line's samples that must be away from edges for the line to be looked at."""


def pattern_lines(group: Group) -> Figures:
    """Rows and columns in the pattern: in the dark over the variance of a pixel in time, in light
    over that of the pattern.
    """
    if group.lit:
        return {
            f"pattern {kind}s": _lines_in_light(group, axis)
            for kind, axis in (("column", 1), ("row", 2))
        }
    a, b = group.halves
    found = {}
    for kind, axis in (("column", 1), ("row", 2)):
        product = (a.mean(axis=axis) * b.mean(axis=axis)).mean(axis=1)
        found[f"pattern {kind}s"] = safe_ratio(product, group.variance)
    return found


def _lines_in_light(group: Group, axis: int) -> Floats:
    """What n samples of a line have in common, of the mean of the samples along an axis (1 or 2).

    With d the second difference across the lines, A and B the halves, and m their mean,

        median over the lines of n <d_A> <d_B>  /  median over the lines of <d_m^2>

    is the median of the square of a normal number, 0.455, where samples are independent and noise
    in time is small, and 0.455 (v + n g^2) / (v + g^2) where their variance is v and gains of lines
    differ by g; of noise in time it is 0. The upright edges of a chart are few lines, so that a
    median is not of them.
    """
    even, light = group.away_from_edges, np.maximum(group.mean, 1.0)
    away = np.moveaxis(even, axis, 2)[:, 1:-1]
    part = away / np.moveaxis(light, axis, 2)[:, 1:-1]
    count = away.sum(axis=2, dtype=np.float64)
    a, b = (
        part * (one[:, 2:] - 2 * one[:, 1:-1] + one[:, :-2])
        for one in (np.moveaxis(half, axis, 2) for half in group.mean_halves)
    )
    of_lines = a.sum(axis=2, dtype=np.float64) * b.sum(axis=2, dtype=np.float64)
    of_samples = np.square(a + b).sum(axis=2, dtype=np.float64) / 4
    left_out = count < max(1.0, LEAST_OF_A_LINE * away.shape[2])
    return safe_ratio(
        *(_median(one / np.maximum(count, 1.0), left_out) for one in (of_lines, of_samples))
    )


def _median(of_lines: Floats, left_out: NDArray[np.bool_]) -> Floats:
    """Median over the lines that are looked at, (k,); 0 where there are none."""
    found = np.zeros(len(of_lines))
    seen = ~left_out.all(axis=1)
    found[seen] = np.nanmedian(np.where(left_out, np.nan, of_lines)[seen], axis=1)
    return found


def pattern_shape(group: Group) -> Figures:
    """Neighbours in the pattern, hot samples, and how skewed it is."""
    if group.lit:
        return {}
    a, b = group.halves
    _, h, w = a.shape
    found = {}
    for dy, dx in LAGS:
        one, other = a[:, dy:, dx:], b[:, : h - dy, : w - dx]
        product = np.einsum("khw,khw->k", one, other) / ((h - dy) * (w - dx))
        found[f"pattern neighbours {dy},{dx}"] = safe_ratio(product, group.variance)
    sigma = np.sqrt(np.maximum(group.variance, ROUNDING_DN2))
    hot = np.minimum(a, b) / sigma[:, None, None]
    found["hot samples"] = np.sqrt((hot > 3).mean(axis=(1, 2)))
    found["very hot samples"] = np.sqrt((hot > 12).mean(axis=(1, 2)))
    third = (a * b * (a + b) / 2).mean(axis=(1, 2), dtype=np.float64)
    found["pattern skewness"] = np.cbrt(third / sigma**3)
    return found


def _cap_in_light(product: Array) -> Floats:
    """A bound that edges of the picture cannot pass: 50 times the typical size."""
    return 50.0 * np.median(np.abs(product[:, ::7]), axis=1).astype(np.float64) + 1e-12


def _cap_in_the_dark(product: Array) -> Floats:
    """A bound that a handful of hot samples cannot pass: 100 times the typical size.

    The typical size is a mean: where noise is below a step of the converter, most products are 0.
    """
    size = np.abs(product)
    most = 100.0 * size.mean(axis=1, keepdims=True)
    typical = np.minimum(size, most).mean(axis=1, dtype=np.float64)
    return np.asarray(100.0 * typical + 1e-12)
