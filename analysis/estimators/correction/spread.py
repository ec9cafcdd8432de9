"""Rounding where levels lie anywhere between two codes: its exact mean, and how to undo it.

Over evenly spread places between codes the mean square of rounded minus true is s^2 + 1/12, and of
it the part of a level's own mean is the power of the sawtooth's Fourier series, which noise damps:

    E var(code) = s^2 + 1/12 - B(s),   B(s) = 1 / (2 pi^2)  sum_k exp(-4 pi^2 k^2 s^2) / k^2.

Without noise B is 1/12 and codes do not change; at 0.3 DN it is 0.0015 DN^2. A pattern of SD t
spreads levels: what is uneven about their places is damped by exp(-2 pi^2 t^2), 7 in 1000 at 0.5.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq

SPREAD_DN = 0.5
"""SD of levels over sites from which their places between codes pass for evenly spread."""

LEAST_DN = 0.24
"""Noise below which codes do not tell it: a site then gives one or two codes, and noise and pattern
can only be told from each other by the far tails of their distributions, if at all."""

SAFE_DN = 0.3
"""Noise from which the sawtooth left in the levels no longer counts as pattern: below 0.0015 DN^2
where the pattern that spreads them has 0.25."""

TERMS = 8


def sawtooth(sigma_dn: float) -> float:
    """B(s) in DN^2."""
    return sum(
        math.exp(-4 * (math.pi * k * sigma_dn) ** 2) / (2 * (math.pi * k) ** 2)
        for k in range(1, TERMS + 1)
    )


def variance_of_codes(sigma_dn: float) -> float:
    """E var(code) in DN^2; rises with the noise."""
    return sigma_dn**2 + 1 / 12 - sawtooth(sigma_dn)


def noise_behind(variance_dn2: float) -> tuple[float, float]:
    """The noise s in DN whose codes have that variance, and d s^2 / d variance; 0 if too little."""
    if variance_dn2 <= variance_of_codes(0.1):
        return 0.0, 0.0
    top = math.sqrt(variance_dn2)
    sigma = float(brentq(lambda s: variance_of_codes(s) - variance_dn2, 0.1, top))
    damped = (math.exp(-4 * (math.pi * k * sigma) ** 2) for k in range(1, TERMS + 1))
    return sigma, 1 / (1 + 2 * sum(damped))
