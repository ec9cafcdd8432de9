"""Gains by the noise of typical samples, where a few change by far more than their own light."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.first_guess import BELOW_FULL
from analysis.gap.camera.twin import NOT_CLIPPED
from analysis.gap.ready.full_well import FEWEST, dark_of, lit, samples_of
from analysis.gap.ready.setting import Setting

Floats = NDArray[np.float64]


def gain_below(setting: Setting, ends_dn: Mapping[str, Floats]) -> Floats | None:
    """Gain in DN/e- by channel, by photon transfer of samples well below an end: by how much more
    they change than dark ones, over how much brighter they are. None where there are too few.

    By medians of samples that are about as bright: what runs over from full ones comes and goes,
    and changes a few by far more than their own light.

    Args:
        setting: the capture.
        ends_dn: where samples end by label of a lit shot, (channels,); infinite where they do not.
    """
    sums = np.array([np.sum(one, axis=0) for one in _levels(setting, ends_dn)])
    return sums[:, 0] / sums[:, 1] if sums.ndim == 2 and (sums > 0).all() else None


def typical_gain(setting: Setting, ends_dn: Mapping[str, Floats]) -> Floats | None:
    """Gain in DN/e- by channel, (channels,), by photon transfer of samples well below an end: the
    slope, variance over mean beyond the dark, above and below which lies half of the light. Of a
    picture that trembles many samples between two levels are edges. None where there are too few.

    Args:
        setting, ends_dn: see `gain_below`.
    """
    gains = []
    for levels in _levels(setting, ends_dn):
        lit_ones = [(more / above, above) for more, above in levels if above > 0]
        if not lit_ones:
            return None
        slopes, weights = np.array(sorted(lit_ones)).T
        gains.append(slopes[np.searchsorted(np.cumsum(weights), weights.sum() / 2.0)])
    return np.array(gains) if min(gains) > 0 else None


def _levels(setting: Setting, ends_dn: Mapping[str, Floats]) -> list[list[tuple[float, float]]]:
    """Variance beyond that of darks in DN^2, and mean above theirs in DN, each times the number of
    samples that are about as bright, by channel.
    """
    channels = setting.seen.channels
    levels: list[list[tuple[float, float]]] = [[] for _ in channels]
    for lattice in setting.scenery.view.lattices:
        c = channels.index(lattice.channel)
        dark = dark_of(setting.key_frames, lattice)
        for stack in lit(setting.key_frames):
            one = samples_of(stack, lattice)
            end_dn = min(ends_dn[stack.shot.label][c], NOT_CLIPPED * stack.top_dn)
            below = np.flatnonzero(one.mean < dark.mean_dn + BELOW_FULL * (end_dn - dark.mean_dn))
            darkest_first = below[np.argsort(one.mean[below])]
            count = len(below) // FEWEST
            for alike in np.array_split(darkest_first, count) if count else ():
                usual_dn2 = np.median(one.variance[alike]) / _median_of_variance(one.frames)
                more_dn2 = len(alike) * (float(usual_dn2) - dark.variance_dn2)
                above_dn = len(alike) * (float(one.mean[alike].mean()) - dark.mean_dn)
                levels[c].append((more_dn2, above_dn))
    return levels


def _median_of_variance(frames: int) -> float:
    """Median of the variance of so many normal numbers, over its mean: Wilson and Hilferty (1931)
    of chi-squared."""
    return float((1.0 - 2.0 / (9.0 * (frames - 1))) ** 3)
