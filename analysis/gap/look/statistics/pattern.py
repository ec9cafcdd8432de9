"""The fixed pattern: what stays from frame to frame, by two halves of a group.

Products of the halves have no bias from noise in time.
"""

from __future__ import annotations

import numpy as np

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.statistics.group import Array, Group, safe_ratio

LAGS = ((0, 1), (1, 0), (1, 1), (0, 2), (0, 4), (4, 0))


def pattern(group: Group) -> dict[str, float]:
    """Variance of the pattern over the square of its mean in light, in DN^2 in the dark."""
    a, b = group.halves if not group.lit else group.crossed_halves
    product = (a * b).ravel()
    cap = _cap_in_light(product) if group.lit else _cap_in_the_dark(product)
    scale = max(float(np.square(group.mean).mean()), 1.0) * 1e-4 if group.lit else 1.0
    return {"pattern variance": float(np.mean(np.clip(product, -cap, cap))) / scale}


def pattern_lines(group: Group) -> dict[str, float]:
    """Rows and columns in the pattern, over the variance of a pixel in time."""
    if group.lit:
        return {}
    a, b = group.halves
    found = {}
    for kind, axis in (("column", 0), ("row", 1)):
        product = float((a.mean(axis=axis) * b.mean(axis=axis)).mean())
        found[f"pattern {kind}s"] = safe_ratio(product, group.variance)
    return found


def pattern_shape(group: Group) -> dict[str, float]:
    """Neighbours in the pattern, hot samples, and how skewed it is."""
    if group.lit:
        return {}
    a, b = group.halves
    scale = group.variance
    h, w = a.shape
    found = {}
    for dy, dx in LAGS:
        product = float((a[dy:, dx:] * b[: h - dy, : w - dx]).mean())
        found[f"pattern neighbours {dy},{dx}"] = safe_ratio(product, scale)
    sigma = np.sqrt(max(scale, ROUNDING_DN2))
    hot = np.minimum(a, b) / sigma
    found["hot samples"] = float(np.sqrt((hot > 3).mean()))
    found["very hot samples"] = float(np.sqrt((hot > 12).mean()))
    found["pattern skewness"] = float(np.cbrt((a * b * (a + b) / 2).mean() / sigma**3))
    return found


def _cap_in_light(product: Array) -> float:
    """A bound that edges of the picture cannot pass: 50 times the typical size."""
    return 50.0 * float(np.median(np.abs(product[::7]))) + 1e-12


def _cap_in_the_dark(product: Array) -> float:
    """A bound that a handful of hot samples cannot pass: 100 times the typical size.

    The typical size is a mean: where noise is below a step of the converter, most products are 0.
    """
    size = np.abs(product)
    return 100.0 * float(np.minimum(size, 100.0 * size.mean()).mean()) + 1e-12
