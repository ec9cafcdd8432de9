"""Noise against signal: variance in time by level, and where values are clipped."""

from __future__ import annotations

import numpy as np

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.statistics.group import Figures, Group

BINS = 4
"""Parts of the image by brightness, each with as many pixels."""


def transfer(group: Group) -> Figures:
    """Logarithm of the variance in time, of all pixels and by brightness.

    A twelfth of a DN^2 is added, so that noise-free dark frames have a logarithm.
    """
    k = len(group.codes)
    spread = group.energy.reshape(k, -1) / np.float32(group.frames - 1)
    mean = spread.mean(axis=1, dtype=np.float64)
    found = {"variance": np.log(mean + ROUNDING_DN2)}
    if group.lit:
        brightness = group.mean.reshape(k, -1)
        some = group.mean[:, ::4, ::4].reshape(k, -1)
        edges = np.quantile(some, np.linspace(0, 1, BINS + 1)[1:-1], axis=1)
        above = [(brightness >= edge[:, None]).astype(np.float32) for edge in edges]
        ones = np.ones(1, np.float32)
        counts = [group.pixels, *(one.sum(axis=1) for one in above), 0.0]
        totals = [mean * group.pixels, *(np.vecdot(one, spread) for one in above), 0.0]
        for part in range(BINS):
            count, total = counts[part] - counts[part + 1], totals[part] - totals[part + 1]
            typical = np.where(count > 0, total / np.maximum(count, ones), mean)
            found[f"variance, part {part + 1}"] = np.log(typical + ROUNDING_DN2)
    return found


def level(group: Group) -> Figures:
    """Mean pixel value in the dark, where no light can be adjusted to it."""
    return {} if group.lit else {"dark level": group.mean.mean(axis=(1, 2), dtype=np.float64)}
