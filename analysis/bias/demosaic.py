"""What a bilinear demosaic and a parabola per column leave of white noise: exact factors.

At each of the four sites of a 2 x 2 cell a channel is the sample itself, or the mean of 2 or 4
neighbours: noise is 1, 1/sqrt(2) or 1/2 of the sample's. Interpolated neighbours share samples, so
noise is correlated down a column, and the parabola takes more than 3 of its degrees of freedom:

    E |P y|^2 = tr(P C),   C the covariance down the column, P = 1 - fit.
"""

from __future__ import annotations

import functools

import numpy as np

from analysis.bias.rounding import Floats
from analysis.estimators.parts.panel_noise import parabola_basis

SITES: dict[str, tuple[float, ...]] = {
    "R": (1.0, 0.5**0.5, 0.5**0.5, 0.5),
    "G": (1.0, 1.0, 0.5, 0.5),
    "B": (1.0, 0.5**0.5, 0.5**0.5, 0.5),
}
"""Equations (4) to (7) of Irie et al., site by site, before they are averaged."""


def site_factors(channel: str, *, demosaiced: bool) -> Floats:
    """SD of interpolated white noise at the sites of a cell, relative to the samples' own."""
    return np.array(SITES[channel] if demosaiced else (1.0,))


@functools.cache
def detrended_variance(channel: str, rows: int, columns: int, *, demosaiced: bool) -> float:
    """Variance that the spatial measure finds in white noise of variance 1: N_D^2 against raw.

    The sum of squares that column parabolas leave, over samples less one, as measured.
    """
    projection = np.eye(rows) - parabola_basis(rows) @ parabola_basis(rows).T
    if not demosaiced:
        return float(np.trace(projection) * columns / (rows * columns - 1))
    kept = [float(np.trace(projection @ _covariance(channel, rows, odd))) for odd in (0, 1)]
    wide = (columns + 1) // 2, columns // 2
    return (kept[0] * wide[0] + kept[1] * wide[1]) / (rows * columns - 1)


def _covariance(channel: str, rows: int, odd: int) -> Floats:
    """Covariance down a column of a demosaiced channel; `odd` says which of two kinds of column.

    Red and blue: samples in every second row of every second column. Green: a quincunx.
    """
    reach = rows + 2
    weights = np.zeros((rows, reach, 3))  # contributions of samples one left, same, one right
    for y in range(rows):
        at = y + 1
        if channel == "G":
            if (y + odd) % 2 == 0:
                weights[y, at, 1] = 1
            else:
                weights[y, at - 1, 1] = weights[y, at + 1, 1] = 0.25
                weights[y, at, 0] = weights[y, at, 2] = 0.25
        else:
            rows_used = [(at, 1.0)] if y % 2 == 0 else [(at - 1, 0.5), (at + 1, 0.5)]
            for row, share in rows_used:
                for side in [1] if odd == 0 else [0, 2]:
                    weights[y, row, side] = share * (1 if odd == 0 else 0.5)
    flat = weights.reshape(rows, -1)
    return np.asarray(flat @ flat.T)
