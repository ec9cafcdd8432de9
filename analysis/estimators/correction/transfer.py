"""Photon transfer: noise in time as a line in exposure and level, fitted to all panels at once.

A photo-electron count of mean N has variance N; at g DN per electron a level of I DN above black
has variance g I. With the read noise r and dark current, whose charge grows with the exposure t,

    s^2 = r^2 + D t + g I,       I = mean - black,

which is linear in r^2, D and g. Every lattice of every shot is a point; its weight is the inverse
of its own variance, 2 s^4 / (n (N - 1)) for n sites and N frames, with s^2 taken from the fitted
line: weights from the measured variances would favour those that came out small.

A straight line is the model. One more term tests it: a shot noise of k sqrt(I) + c has the variance
k^2 I + 2 k c sqrt(I) + c^2, so to first order c is the coefficient of 2 k sqrt(I). Its estimate is
the paper's offset of equation (14), 0 for a Poisson count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.estimators.parts.panel_noise import Floats

ROUNDS = 4
"""Refits with weights from the fitted line; the second already changes nothing to speak of."""

SINGULAR = 300.0
"""Condition from which a design does not carry its terms."""

DOUBT = 1e-3
"""Chance of a misfit below which errors are widened to it."""


LEAST_SPAN_DN = 1.0
"""Levels that span less than this carry no line."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Transfer:
    """The fitted line; figures with their standard errors, None where the points do not tell.

    Attributes:
        read_dn2: r^2; with one dark exposure it holds the dark current's shot noise.
        dark_dn2: D t at the longest dark exposure.
        gain: g in DN/e-.
        offset_dn: c.
        chi2, freedom, chance: misfit of the line, its degrees of freedom, and its p-value.
    """

    read_dn2: tuple[float, float] | None
    dark_dn2: tuple[float, float] | None
    gain: tuple[float, float] | None
    offset_dn: tuple[float, float] | None
    chi2: float
    freedom: int
    chance: float


def fit_transfer(
    variance: Floats, se: Floats, level: Floats, exposure: Floats, dark: NDArray[np.bool_]
) -> Transfer:
    """Fit the points (n,).

    Args:
        variance, se: temporal variance in DN^2 and its standard error.
        level: above black, 0 for darks.
        exposure: in s.
        dark: which points are dark.
    """
    columns = {"read": np.ones_like(variance)}
    if len(set(exposure[dark])) > 1:
        columns["dark"] = exposure / exposure[dark].max()
    if np.ptp(level) >= LEAST_SPAN_DN:
        columns["gain"] = level
    names = list(columns)
    design = np.stack(list(columns.values()), axis=1)
    relative = se / variance
    error, fitted = se, variance
    for _ in range(ROUNDS):
        parameters, covariance = _solve(design, variance, error)
        fitted = design @ parameters
        error = relative * np.maximum(fitted, 0.05 * variance)
    residual = (variance - fitted) / error
    chi2, freedom = float(residual @ residual), len(variance) - design.shape[1]
    chance = float(stats.chi2.sf(chi2, freedom)) if freedom > 0 else 1.0
    widen = chi2 / freedom if chance < DOUBT else 1.0
    if not dark.any():
        names[0] = "nuisance"
    found = {
        name: (float(parameters[k]), float(np.sqrt(widen * covariance[k, k])))
        for k, name in enumerate(names)
    }
    gain = found.get("gain")
    offset = None
    if gain is not None and gain[0] > 0:
        root = 2 * np.sqrt(gain[0] * np.maximum(level, 0.0))
        more = np.column_stack([design, root])
        if len(variance) > more.shape[1] and np.linalg.cond(more / more.max(axis=0)) < SINGULAR:
            wider, covariance = _solve(more, variance, error)
            offset = (float(wider[-1]), float(np.sqrt(widen * covariance[-1, -1])))
    return Transfer(
        read_dn2=found.get("read"),
        dark_dn2=found.get("dark"),
        gain=gain,
        offset_dn=offset,
        chi2=chi2,
        freedom=freedom,
        chance=chance,
    )


def _solve(design: Floats, points: Floats, error: Floats) -> tuple[Floats, Floats]:
    """Weighted least squares: parameters and their covariance."""
    scaled = design / error[:, None]
    size = np.linalg.norm(scaled, axis=0)
    size[size == 0] = 1.0
    inverse = np.linalg.pinv(scaled / size)
    parameters = inverse @ (points / error) / size
    return parameters, inverse @ inverse.T / np.outer(size, size)
