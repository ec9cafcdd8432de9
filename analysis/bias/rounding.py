"""What rounding to whole DN makes of Gaussian noise: exact moments at any level.

For y = clip(round(x), 0, top) and x normal with mean m and SD s, by summation over thresholds,

    E[f(y)] = f(0) + sum_k (f(k) - f(k - 1)) P(y >= k),   P(y >= k) = Phi((m - k + 1/2) / s).

Sheppard's variance s^2 + 1/12 is the limit of s well above a step; below half a step the variance
depends on where m lies between two codes, which is what Figs. 2 and 3 of Irie et al. show.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln, ndtr

Floats = NDArray[np.float64]

ROUNDING_DN2 = 1 / 12
"""Variance that rounding to whole DN adds, of noise well above a step."""

REACH = 9.0
"""SDs beyond which a Gaussian has nothing that double precision would show."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Rounded:
    """Moments of rounded, clipped noise: mean and SD in DN, kurtosis (3 for a Gaussian)."""

    mean_dn: Floats
    sd_dn: Floats
    kurtosis: Floats

    def sample_sd_dn(self, samples: int) -> Floats:
        """Mean of the SD of so many samples.

        The sample variance has the mean v and the variance v^2 / k with
        1 / k = (kurtosis - 3) / n + 2 / (n - 1); its root is
        taken as that of a gamma distribution of shape k, which is exact for a Gaussian.
        """
        shape = 1 / np.maximum((self.kurtosis - 3) / samples + 2 / (samples - 1), 1e-12)
        return np.asarray(
            self.sd_dn * np.exp(gammaln(shape + 0.5) - gammaln(shape)) / np.sqrt(shape)
        )


def rounded(mean_dn: ArrayLike, sd_dn: ArrayLike, top_dn: int = 255) -> Rounded:
    """Moments of rounded, clipped Gaussian noise; arguments in DN, they broadcast.

    Sums are taken about the code below each mean, so that no digits are lost at high levels.
    """
    m, s = np.broadcast_arrays(
        np.asarray(mean_dn, dtype=np.float64), np.asarray(sd_dn, dtype=np.float64)
    )
    half = int(np.ceil(REACH * float(s.max(initial=0.0)))) + 1
    base = np.floor(m)
    scale = np.where(s > 0, s, 1.0)
    raw = np.zeros((4, *m.shape))
    for step in range(-half, half + 1):
        code = base + step  # its threshold lies half a step below it
        over = m - code + 0.5
        above = np.where(s > 0, ndtr(over / scale), over > 0)
        above = np.where(code > top_dn, 0.0, np.where(code < 1, 1.0, above))
        counted = above if step > 0 else above - 1  # from the base, up or down
        for power in range(1, 5):
            raw[power - 1] += (step**power - (step - 1) ** power) * counted
    a, b, c, d = raw
    variance = np.maximum(b - a**2, 0.0)
    fourth = d - 4 * a * c + 6 * a**2 * b - 3 * a**4
    tiny = variance < 1e-12
    return Rounded(
        mean_dn=base + a,
        sd_dn=np.where(tiny, 0.0, np.sqrt(variance)),
        kurtosis=np.where(tiny, 3.0, fourth / np.where(tiny, 1.0, variance) ** 2),
    )


def sample_sd_factor(samples: int) -> float:
    """c4: the mean of the SD of so many Gaussian samples, relative to the true one."""
    half = samples / 2
    return float(np.sqrt(2 / (samples - 1)) * np.exp(gammaln(half) - gammaln(half - 0.5)))


TERMS = 64
"""Of the series of a sawtooth; of noise that is a hundredth of a step the next ones have 2e-12 of a
step squared, and less of more noise."""

QUIETEST_DN, LOUDEST_DN = 1e-2, 100.0
"""SDs between which noise is told from what rounding makes of it."""


def on_average_dn2(variance_dn2: ArrayLike) -> Floats:
    """Variance in time that noise has behind rounding, on average over levels anywhere between two
    codes.

    The mean of rounded noise is its level and a sawtooth that the noise has smoothed; the squares
    of both noises add up to Sheppard's sum over all levels, and that of the sawtooth is no noise:

        v = s^2 + 1/12 - sum_k exp(-(2 pi k s)^2) / (2 pi^2 k^2)

    It is s / sqrt(pi) of little noise, as one of two codes is seen near a threshold, and
    s^2 + 1/12 of much.

    Args:
        variance_dn2: s^2, of normal noise.
    """
    k = np.arange(1, TERMS + 1)
    variance = np.asarray(variance_dn2, dtype=np.float64)[..., None]
    sawtooth = np.exp(-np.square(2 * np.pi * k) * variance) / (2 * np.square(np.pi * k))
    return np.asarray(variance[..., 0] + ROUNDING_DN2 - sawtooth.sum(axis=-1))


def before_rounding_dn2(variance_dn2: ArrayLike) -> Floats:
    """Variance of noise in front of rounding, by what it has behind it on average over levels: the
    inverse of `on_average_dn2`, to a thousandth.
    """
    before = np.square(np.geomspace(QUIETEST_DN, LOUDEST_DN, 8192))
    return np.interp(np.asarray(variance_dn2, dtype=np.float64), on_average_dn2(before), before)
