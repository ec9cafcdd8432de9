"""Shading of a panel: the smooth part of its mean image, of a degree that the image asks for.

A polynomial in both directions of the panel is taken off, and the degrees of freedom that it
takes are counted exactly: independent sites less the rank of the fit. Its degree rises while the
next one still explains more of some shot than white patterns do (F-test). One more degree is then
taken: shading that the test just misses would count as fixed pattern, a bias, while a degree too
many only costs its few degrees of freedom, which are known.
"""

from __future__ import annotations

import functools

import numpy as np
from scipy import stats

from analysis.estimators.parts.panel_noise import Floats

SIGNIFICANCE = 0.1
"""Chance that even patterns ask for one degree more; liberal, as overfit is nearly free."""

MOST = 6
"""Highest degree; shading within a panel of a chart is far smoother."""

SITES_PER_TERM = 8
"""Sites that each coefficient must at least have."""


@functools.lru_cache(maxsize=256)
def _basis(row: bytes, column: bytes, degree: int) -> Floats:
    y, x = (np.frombuffer(part, dtype=np.float64) for part in (row, column))
    y, x = (2 * (t - t.min()) / max(np.ptp(t), 1.0) - 1 for t in (y, x))
    powers = [(total - j, j) for total in range(degree + 1) for j in range(total + 1)]
    legendre = np.polynomial.legendre.legvander
    of_y, of_x = legendre(y, degree), legendre(x, degree)
    q = np.linalg.qr(np.stack([of_y[:, i] * of_x[:, j] for i, j in powers], axis=1))[0]
    q.setflags(write=False)
    return q


def basis(row: Floats, column: Floats, degree: int) -> Floats:
    """Orthonormal columns (n, p) spanning the polynomials of a total degree over sites (n,).

    They come in order of degree: the first (d + 1) (d + 2) / 2 columns span degree d.
    """
    return _basis(
        np.ascontiguousarray(row).tobytes(), np.ascontiguousarray(column).tobytes(), degree
    )


def terms(degree: int) -> int:
    """Coefficients of a polynomial in two variables."""
    return (degree + 1) * (degree + 2) // 2


def highest(rows: int, columns: int) -> int:
    """The highest degree that a lattice of that size can carry."""
    degree = 0
    while (
        degree < MOST
        and degree + 2 < min(rows, columns)
        and SITES_PER_TERM * terms(degree + 1) <= rows * columns
    ):
        degree += 1
    return degree


def degree_of(images: Floats, row: Floats, column: Floats, limit: int) -> int:
    """The degree that mean images (shots, n) of one panel ask for, one more for safety.

    Args:
        images: one per shot; their patterns may be shared, so the tests are not independent and
            the smallest p-value is held against the significance over their number.
        row, column: place of each site.
        limit: the highest degree allowed.
    """
    q = basis(row, column, limit)
    n = images.shape[1]
    coefficients = images @ q
    whole = np.einsum("ij,ij->i", images, images)
    for degree in range(limit):
        p, more = terms(degree), terms(degree + 1)
        left = whole - np.einsum("ij,ij->i", coefficients[:, :more], coefficients[:, :more])
        gain = np.einsum("ij,ij->i", coefficients[:, p:more], coefficients[:, p:more])
        f = (gain / (more - p)) / np.maximum(left / (n - more), 1e-30)
        chance = float(stats.f.sf(f, more - p, n - more).min())
        if chance * len(images) > SIGNIFICANCE:
            return degree + 1
    return limit
