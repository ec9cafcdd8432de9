"""High-pass of EMVA 1288: what a lamp or a lens does slowly is taken off, pixel noise stays.

The image less itself smoothed by a 7 x 7 box, an 11 x 11 box and a 3 x 3 binomial filter. The
standard's images are whole sensors, where neither their edges nor the little noise that the
smoothing keeps matter. A panel is small: edges are continued straight, by reflection through the
edge pixel, so that a ramp is taken off to the rim, and the share of white noise that survives is
computed exactly and divided out. Both are ours.
"""

from __future__ import annotations

import functools

import numpy as np

from analysis.estimators.parts.map_error import se_of_mean
from analysis.estimators.parts.panel_noise import Floats

KERNEL: Floats = np.convolve(
    np.convolve(np.full(7, 1 / 7), np.full(11, 1 / 11)), np.array([0.25, 0.5, 0.25])
)
"""The smoothing along one axis; the filters are separable."""


@functools.cache
def smoothing(samples: int) -> Floats:
    """The smoothing of a line of samples as a matrix (samples, samples)."""
    reach = len(KERNEL) // 2
    matrix = np.empty((samples, samples))
    for k, unit in enumerate(np.eye(samples)):
        longer = np.pad(unit, reach, mode="reflect", reflect_type="odd")
        matrix[:, k] = np.convolve(longer, KERNEL, mode="valid")
    matrix.setflags(write=False)
    return matrix


def spatial_variance(image: Floats) -> tuple[float, float]:
    """Variance of an image (h, w) after the high-pass, as of white noise, and its standard error.

    The high-pass is 1 - A x B with the smoothing A of columns and B of rows, so of n pixels of
    white noise it keeps n - 2 tr A tr B + |A|^2 |B|^2 in sum of squares.
    """
    a, b = smoothing(image.shape[0]), smoothing(image.shape[1])
    level = image - image.mean()
    left = level - a @ level @ b.T
    kept = 1 - (2 * np.trace(a) * np.trace(b) - np.sum(a * a) * np.sum(b * b)) / image.size
    squares = left * left / kept
    return float(squares.mean()), se_of_mean(squares)
