"""Likelihood of rounded, clipped pixel values: what codes say of a level and a noise.

A sample is a Gaussian of mean m and SD s, rounded to the nearest code and clipped to 0 and the
top. The chance of a code k is the part of the Gaussian that rounds to it,

    P(k | m, s) = Phi((k + 1/2 - m) / s) - Phi((k - 1/2 - m) / s),

with the lower edge of code 0 at minus, the upper edge of the top code at plus infinity. Frames of
one pixel are independent, so its counts n_k over the codes are all that it can say. Pixels of a
panel differ by a smooth level c_i and a fixed pattern of SD tau, whose value in this pixel is not
known and is integrated out:

    L(s, tau, c) = prod_i  Integral dm  N(m; c_i, tau^2)  prod_k P(k | m, s)^n_ik.

No variance of rounding is subtracted, nothing is assumed of where levels lie between codes, and
clipping at 0 is part of the model. The integral is a sum over a grid that all pixels share, with a
step as wide as the narrowest posterior: for Gaussians that sum errs by 2 exp(-2 pi^2), 5e-9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from analysis.estimators.parts.panel_noise import Floats

STEPS = 30
"""Most iterations; five are usual."""

CONVERGED = 0.02
"""Step in standard errors at which the iteration ends."""

LEAST_TAU = 0.1
"""Floor of the pattern's SD, relative to the error of a level: what is finer does not matter."""

LEAST_SIGMA_DN = 0.1
"""Floor of the noise, far below what codes can tell; it keeps the grid short."""

REACH = 4.5
"""How far the grid goes beyond the outermost pixel's level, in SDs of that level's error."""

LEAST_P = 1e-290
"""Floor of a probability, so that its logarithm is finite where no sample will ever be."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CodeFit:
    """The most likely noise of a stack of codes.

    Attributes:
        variance_dn2: s^2, before rounding.
        variance_se_dn2: its standard error, tau being fitted too.
        centre_dn: smooth levels c_i, (n,).
        level_dn: levels of the pixels with the pattern, (n,): an estimate y_i that is calibrated,
            so that y_i = m_i + error, the error of variance `level_variance_dn2` and independent
            of m_i.
        level_variance_dn2: see there.
        resolved: share of the pattern's variance that the codes resolve, 0 to 1.
    """

    variance_dn2: float
    variance_se_dn2: float
    centre_dn: Floats
    level_dn: Floats
    level_variance_dn2: float
    resolved: float


def count_codes(samples: NDArray[np.integer], low: int, high: int) -> Floats:
    """How often each pixel gave each code: samples (N, n) to counts (n, high - low + 1)."""
    pixels, codes = samples.shape[1], high - low + 1
    index = samples.astype(np.int32)
    index += np.arange(pixels, dtype=np.int32) * codes - low
    return (
        np.bincount(index.ravel(), minlength=pixels * codes)
        .reshape(pixels, codes)
        .astype(np.float64)
    )


def log_probability(
    grid: Floats, sigma: float, low: int, codes: int, top: int
) -> tuple[Floats, Floats]:
    """ln P(k | m, s) and its derivative by ln s, for codes from `low` on and levels of a grid.

    Returns:
        two arrays (codes, len(grid)).
    """
    edge = np.arange(low, low + codes + 1) - 0.5
    if low <= 0:
        edge[0] = -np.inf
    if low + codes - 1 >= top:
        edge[-1] = np.inf
    z = (edge[:, None] - grid[None, :]) / sigma
    with np.errstate(invalid="ignore"):
        slope = np.where(np.isfinite(z), z * np.exp(-0.5 * z * z) / np.sqrt(2 * np.pi), 0.0)
    below, above = z[:-1], z[1:]
    # On the far side differences of the other tail keep their digits.
    flip = below > 0
    p = np.where(flip, ndtr(-below) - ndtr(-above), ndtr(above) - ndtr(below))
    p = np.maximum(p, LEAST_P)
    return np.log(p), (slope[:-1] - slope[1:]) / p


def fit_codes(
    counts: Floats,
    low: int,
    top: int,
    basis: Floats,
    *,
    centre: Floats,
    sigma: float,
    tau: float,
) -> CodeFit:
    """Maximise L over s, tau and the coefficients of the smooth level.

    Args:
        counts: (n, K), see `count_codes`.
        low: code of the first column.
        top: the largest code that the camera can give.
        basis: orthonormal columns (n, p) that span the smooth levels.
        centre, sigma, tau: where to start.
    """
    n, codes = counts.shape
    frames = float(counts[0].sum())
    freedom = n - basis.shape[1]
    shrunk = spread = 0.0
    mean = centre
    information = np.eye(2)
    resolved = 1.0
    for _ in range(STEPS):
        tau = max(tau, LEAST_TAU * sigma / frames**0.5)
        width = (1 / (sigma * sigma / frames) + 1 / tau**2) ** -0.5
        grid = _grid(mean, centre, sigma / frames**0.5, tau, width)
        ln_p, by_sigma = log_probability(grid, sigma, low, codes, top)
        away = grid[None, :] - centre[:, None]
        ln_weight = counts @ ln_p
        ln_weight -= away * away * (0.5 / tau**2)
        ln_weight -= ln_weight.max(axis=1, keepdims=True)
        weight = np.exp(ln_weight, out=ln_weight)
        weight /= weight.sum(axis=1, keepdims=True)

        offset = np.einsum("ij,ij->i", weight, away)
        square = np.einsum("ij,ij,ij->i", weight, away, away)
        score = np.stack([np.einsum("ij,ij->i", weight, counts @ by_sigma), square / tau**2 - 1.0])
        information = score @ score.T
        spread = float(np.mean(square - offset * offset))
        resolved = max(1.0 - spread / tau**2, 1e-6)
        shrunk = tau * tau * (1 - resolved) / resolved
        level = offset / resolved
        shift = basis @ (basis.T @ level)
        mean = centre + offset
        residual = level - shift
        variance = float(residual @ residual) / freedom
        # Scores far from the summit scatter too much to scale a step; what is expected does not.
        share = weight.sum(axis=0) @ np.einsum("kg,kg,kg->g", np.exp(ln_p), by_sigma, by_sigma)
        step = float(np.clip(score[0].sum() / max(frames * float(share), 1e-9), -0.5, 0.5))
        step_tau = 0.5 * np.log(max(variance - shrunk, LEAST_TAU**2 * shrunk) / tau**2)
        pixels = centre + level
        centre = centre + shift
        sigma = max(sigma * float(np.exp(step)), LEAST_SIGMA_DN)
        tau *= float(np.exp(np.clip(step_tau, -0.7, 0.7)))
        if step * step * information[0, 0] < CONVERGED**2 and abs(step_tau) < 0.01:
            break
    cross = information[0, 1] ** 2 / max(information[1, 1], 1e-12)
    se_ln = max(information[0, 0] - cross, 1e-12) ** -0.5
    return CodeFit(
        variance_dn2=sigma * sigma,
        variance_se_dn2=2 * sigma * sigma * float(se_ln),
        centre_dn=centre,
        level_dn=pixels,
        level_variance_dn2=shrunk,
        resolved=resolved,
    )


def _grid(mean: Floats, centre: Floats, error: float, tau: float, width: float) -> Floats:
    """Levels that cover every pixel's posterior, a posterior's width apart."""
    reach = REACH * max(width, error) + 2 * error
    low = min(float(mean.min()), float(centre.min()) - 3 * tau) - reach
    high = max(float(mean.max()), float(centre.max()) + 3 * tau) + reach
    return np.linspace(low, high, int(np.ceil((high - low) / width)) + 1)
