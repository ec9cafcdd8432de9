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
        edges = np.quantile(group.mean[::4, ::4], np.linspace(0, 1, BINS + 1)[1:-1])
        which = np.searchsorted(edges, group.mean.ravel(), side="right")
        count = np.bincount(which, minlength=BINS)
        total = np.bincount(which, by_pixel.ravel(), minlength=BINS)
        typical = np.where(count > 0, total / np.maximum(count, 1), by_pixel.mean())
        for k in range(BINS):
            found[f"variance, part {k + 1}"] = float(np.log(typical[k] + ROUNDING_DN2))
    return found


def level(group: Group) -> dict[str, float]:
    """Mean pixel value in the dark, where no light can be adjusted to it."""
    return {} if group.lit else {"dark level": float(group.mean.mean())}
