"""What tests of charge share: the bench's own noise, covariances, and impostors that must fail."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from tests.effects_bench import READ_E, Array

NOISE = READ_E**2 + 1 / 12
"""Variance in e-^2 that the bench itself adds to every pixel: read noise and rounding."""


def must_fail(check: Callable[..., None], *impostor: object) -> None:
    """The check refuses the impostor; one that lets it pass would show nothing."""
    with pytest.raises(AssertionError):
        check(*impostor)


def residuals(frames: Array) -> Array:
    """Frames less their mean, scaled so that mean squares are variances without bias."""
    return (frames - frames.mean(0)) * math.sqrt(len(frames) / (len(frames) - 1))


def lagged(noise: Array, dy: int, dx: int) -> float:
    """Mean product of noise with itself dy below and dx to the right."""
    _, height, width = noise.shape
    return float((noise[:, : height - dy, : width - dx] * noise[:, dy:, dx:]).mean())


def lagged_error(variance: float, frames: Array) -> float:
    """Standard error of such a mean: variance / sqrt(n); 5 % more for what is slightly correlated.

    Bartlett's sum of squared correlations stays below 1.1 for every case here.
    """
    samples = (len(frames) - 1) * (frames.shape[1] - 1) * (frames.shape[2] - 1)
    return 1.05 * variance / math.sqrt(samples)


def gaussian(like: Array, mean: object, variance: object, seed: int = 5) -> Array:
    """Independent Gaussian frames of a given mean and variance."""
    noise = np.random.default_rng(seed).standard_normal(like.shape)
    return np.asarray(mean) + np.sqrt(np.asarray(variance)) * noise
