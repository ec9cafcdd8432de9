"""The fixed pattern: what stays from frame to frame, by two halves of a group.

Products of the halves have no bias from noise in time.
"""

from __future__ import annotations

import cv2
import numpy as np

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.statistics.group import Array, Figures, Floats, Group, safe_ratio

LAGS = ((0, 1), (1, 0), (1, 1), (0, 2), (0, 4), (4, 0))
"""Rows and columns between the two samples of each product."""


STEEP = 0.02
"""Change of the picture from one sample to the next, as a part of it, from which it is an edge: a
pattern of 1 % leaves 0.003 in the mean of 3 x 3 samples, and lamps shade by less than 0.005."""

LEAST_EVEN = 0.05
"""Part of the samples that must be away from edges for them alone to be looked at."""


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
    even = _even(group.mean)[:, 1:-1, 1:-1].reshape(k, -1)
    square = np.square(group.mean[:, 1:-1, 1:-1]).reshape(k, -1)
    variance, light = (np.asarray(np.vecdot(even, one), np.float64) for one in (capped, square))
    return {"pattern variance": safe_ratio(variance, np.maximum(light, even.sum(axis=1)) * 1e-4)}


def _even(images: Array) -> Array:
    """1 away from the edges of a picture (k, h, w), 0 near them; 1 where there is little else."""
    found = []
    for image in images:
        soft = cv2.blur(image, (3, 3), borderType=cv2.BORDER_REFLECT_101)
        steepest = cv2.max(
            cv2.absdiff(soft[2:, 1:-1], soft[:-2, 1:-1]),
            cv2.absdiff(soft[1:-1, 2:], soft[1:-1, :-2]),
        )
        flat = np.ones(image.shape, np.float32)
        flat[1:-1, 1:-1] = steepest < 2 * STEEP * np.abs(soft[1:-1, 1:-1])
        found.append(flat if flat.mean() > LEAST_EVEN else np.ones_like(flat))
    return np.array(found)


def pattern_lines(group: Group) -> Figures:
    """Rows and columns in the pattern, over the variance of a pixel in time."""
    if group.lit:
        return {}
    a, b = group.halves
    found = {}
    for kind, axis in (("column", 1), ("row", 2)):
        product = (a.mean(axis=axis) * b.mean(axis=axis)).mean(axis=1)
        found[f"pattern {kind}s"] = safe_ratio(product, group.variance)
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
    found["pattern skewness"] = _soft_root(third / sigma**3)
    return found


def _soft_root(value: Floats) -> Floats:
    """A cube root of large values; of small ones as they are: a root is steep at zero, where a sign
    that is chance would count as many standard errors."""
    return np.asarray(np.sign(value) * (np.cbrt(1.0 + 3.0 * np.abs(value)) - 1.0))


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
