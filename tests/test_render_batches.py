"""Independent batches: the ratio estimator and the noise it states."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from foundation.panel import Panel
from render.batches import BATCHES, Sums, batches_needed, relative_noise
from render.errors import RenderError

PANEL = Panel(name="1", x=0, y=0, w=4, h=4)


def _sums(y: np.ndarray, z: np.ndarray) -> Sums:
    sums = Sums()
    for batch in zip(y, z, strict=True):
        sums.add(*batch)
    return sums


def test_a_constant_witness_gives_mean_and_standard_error() -> None:
    y = np.random.default_rng(0).normal(5, 1, (9, 3, 3, 3))
    mean, variance = _sums(y, np.full_like(y, 2.0)).estimate(4.0)
    np.testing.assert_allclose(mean, 2 * y.mean(axis=0))
    np.testing.assert_allclose(variance, 4 * y.var(axis=0, ddof=1) / 9, rtol=1e-9)


def test_common_luck_is_divided_out() -> None:
    luck = np.random.default_rng(1).uniform(0.5, 1.5, (8, 4, 4, 3))
    rate, variance = _sums(7 * luck, luck).estimate()
    np.testing.assert_allclose(rate, 7, rtol=1e-12)
    assert np.sqrt(variance).max() < 1e-6


def test_the_ratio_and_its_variance_are_unbiased_to_first_order() -> None:
    rng = np.random.default_rng(2)
    z = rng.normal(1, 0.02, (BATCHES, 200, 200, 3))
    y = 3 * z + rng.normal(0, 0.05, z.shape)
    rate, variance = _sums(y, z).estimate()
    count = rate.size
    expected = 0.05**2 / BATCHES
    level = stats.norm.isf(1e-4 / 4)
    assert abs(rate.mean() - 3) < level * np.sqrt(expected / count)
    # A variance of K batches scatters by sqrt(2 / (K - 1)); second order adds 0.02^2.
    scatter = np.sqrt(2 / (BATCHES - 1) / count)
    assert abs(variance.mean() / expected - 1) < level * scatter + 2 * 0.02**2
    assert abs(rate.var() / expected - 1) < level * np.sqrt(2 / count) + 2 * 0.02**2


def test_where_the_witness_saw_nothing_there_is_nothing() -> None:
    zero = np.zeros((8, 2, 2, 3))
    rate, variance = _sums(zero, zero).estimate()
    assert not rate.any()
    assert not variance.any()


def test_noise_is_that_of_the_worst_panel() -> None:
    rate, variance = np.full((8, 4, 3), 100.0), np.ones((8, 4, 3))
    variance[4:] = 4.0
    lower = Panel(name="2", x=0, y=4, w=4, h=4)
    np.testing.assert_allclose(relative_noise(rate, variance, (PANEL,)), 0.01)
    np.testing.assert_allclose(relative_noise(rate, variance, (PANEL, lower)), 0.02)


def test_batches_follow_the_square_of_the_noise() -> None:
    assert batches_needed(8, 1e-4, 2e-4) == 8
    assert batches_needed(8, 4e-4, 1e-4) == pytest.approx(1.05 * 8 * 16, abs=1)
    with pytest.raises(RenderError, match="expected at most 4096"):
        batches_needed(8, 1e-2, 1e-6)
