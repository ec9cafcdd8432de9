"""Noise against signal: variance in time by level, and where values are clipped."""

from __future__ import annotations

import numpy as np

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.statistics.group import Group

BINS = 4
"""Parts of the image by brightness, each with as many pixels."""


def transfer(group: Group) -> dict[str, float]:
    """Logarithm of the variance in time, of all pixels and by brightness.

    A twelfth of a DN^2 is added, so that noise-free dark frames have a logarithm.
    """
    n = len(group.noise)
    by_pixel = group.energy / (n - 1)
    found = {"variance": float(np.log(by_pixel.mean() + ROUNDING_DN2))}
    if group.lit:
        brightness, spread = group.mean.ravel(), by_pixel.ravel()
        edges = np.quantile(group.mean[::4, ::4], np.linspace(0, 1, BINS + 1)[1:-1])
        above = [(brightness >= edge).astype(np.float32) for edge in edges]
        counts = [brightness.size, *(float(one.sum()) for one in above), 0.0]
        totals = [float(spread.sum()), *(float(one @ spread) for one in above), 0.0]
        mean = float(by_pixel.mean())
        for k in range(BINS):
            count, total = counts[k] - counts[k + 1], totals[k] - totals[k + 1]
            typical = total / count if count > 0 else mean
            found[f"variance, part {k + 1}"] = float(np.log(typical + ROUNDING_DN2))
    return found


def level(group: Group) -> dict[str, float]:
    """Mean pixel value in the dark, where no light can be adjusted to it."""
    return {} if group.lit else {"dark level": float(group.mean.mean())}
