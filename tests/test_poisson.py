"""Poisson counts: the whole distribution, not the mean alone."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy import optimize, stats

from foundation.backend import backend
from sensor.camera_file import load
from sensor.effects.photon_shot import PhotonShot
from sensor.poisson import HIGHEST, SMALL_MEAN, poisson_count, steps_of, steps_reached
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import lit, stream_of
from sensor.stream import Stream
from tests.backends import BACKENDS
from tests.harness import SIGNIFICANCE, assert_agree

MEANS = (0.01, 0.3, 2.0, 11.9, 12.1, 40.0, 900.0, 1e4, 1e5)


def counts(mean: float, where: str, size: int = 200_000) -> np.ndarray:
    b = backend(where)
    stream = Stream(backend=b, seed=5, body_seed=0, effect="e", shot="s", frames=range(4))
    draws = stream.poisson(b.tensor(np.full((1, size // 4), mean)))
    return np.asarray(draws.numpy()).ravel()


def chi_squared_p(sample: np.ndarray, mean: float) -> float:
    """Pearson's test against the Poisson law, in cells of at least 20 expected counts."""
    low, high = stats.poisson.ppf([1e-9, 1 - 1e-9], mean)
    step = max(1, int(math.sqrt(mean) / 8))
    edges = np.arange(low, high + step + 1, step) - 0.5
    expected = np.diff(stats.poisson.cdf(edges, mean)) * sample.size
    observed = np.histogram(sample, edges)[0].astype(float)
    big = expected >= 20
    expected = np.append(expected[big], sample.size - expected[big].sum())
    observed = np.append(observed[big], sample.size - observed[big].sum())
    if expected[-1] < 5:
        expected, observed = expected[:-1], observed[:-1]
    statistic = float(((observed - expected) ** 2 / expected).sum())
    return float(stats.chi2.sf(statistic, max(1, len(expected) - 1)))


@pytest.mark.parametrize("where", BACKENDS)
def test_counts_follow_the_poisson_law_from_a_hundredth_to_a_hundred_thousand(where: str) -> None:
    limit = SIGNIFICANCE / len(MEANS)
    for mean in MEANS:
        assert chi_squared_p(counts(mean, where), mean) > limit, mean


def test_a_rounded_normal_impostor_fails_the_same_test() -> None:
    rng = np.random.default_rng(1)
    for mean in (2.0, 40.0):
        impostor = np.maximum(np.round(rng.normal(mean, math.sqrt(mean), 200_000)), 0)
        assert chi_squared_p(impostor, mean) < SIGNIFICANCE


@pytest.mark.parametrize("where", BACKENDS)
def test_mean_and_variance_are_equal(where: str) -> None:
    for mean in MEANS:
        sample = counts(mean, where)
        fourth = mean + 3 * mean**2
        assert_agree(
            [sample.mean(), sample.var()],
            [mean, mean],
            [math.sqrt(mean / sample.size), math.sqrt((fourth - mean**2) / sample.size)],
            f"mean {mean}",
        )


def test_the_stated_error_of_the_expansion_is_its_error() -> None:
    """Solve Q(w) = n + 1 for every count n and compare with the exact distribution function."""

    def quantile(w: float, m: float) -> float:
        root = math.sqrt(m)
        third = w * (1 / 36 + w * w / 72) / root
        return (
            m + w * root + 1 / 3 + w * w / 6 - third + (w**2 * (7 / 810 + w**2 / 270) - 8 / 405) / m
        )

    for mean, stated in ((SMALL_MEAN, 3.1e-5), (50.0, 1.6e-6)):
        cells = np.arange(int(mean - 4 * math.sqrt(mean)) + 1, int(mean + 6 * math.sqrt(mean)))
        w = [optimize.brentq(lambda x, n=n, m=mean: quantile(x, m) - (n + 1), -7, 9) for n in cells]
        errors = stats.norm.cdf(w) - stats.poisson.cdf(cells, mean)
        assert np.abs(errors).max() < stated
        assert np.abs(errors).max() > stated / 10  # the bound is stated, not padded


def test_mixed_means_in_one_batch_each_keep_their_law() -> None:
    b = backend()
    means = np.array([0.0, 0.5, 11.0, 13.0, 5000.0])
    stream = Stream(backend=b, seed=2, body_seed=0, effect="e", shot="s", frames=range(40_000))
    draws = np.asarray(stream.poisson(b.tensor(means[None])).numpy()).reshape(-1, 5)
    assert (draws[:, 0] == 0).all()
    assert_agree(draws[:, 1:].mean(0), means[1:], np.sqrt(means[1:] / len(draws)))


@pytest.mark.parametrize("mean", [0.0, 1e-6, 0.01, 0.1, 1.0, 5.0, 11.99])
def test_the_rarest_normal_numbers_give_rare_counts(mean: float) -> None:
    """From 5.4 standard deviations on, the probability is 1 in single precision: no sum passes it.
    One number in thirty million is such, and none at all counts where nothing is expected."""
    where = backend()
    if not where.jit:
        pytest.skip("counts of the scalar backend are NumPy's")
    normal = np.array([5.3, 5.4, 5.5, 6.0, 6.6], dtype=np.float32)
    means = where.tensor(np.full(normal.shape, mean, dtype=np.float32)).array
    counts = np.asarray(poisson_count(means, where.tensor(normal).array).numpy())
    most = stats.poisson.isf(1e-11, mean) + 1 if mean > 0 else 0
    least = stats.poisson.isf(1e-6, mean) if mean > 0 else 0
    assert counts.max() <= most
    assert counts.min() >= least


SMALL_MEANS = (0.0, 1e-6, 0.03, 0.5, 2.2, 11.9)


@pytest.mark.parametrize("mean", SMALL_MEANS)
def test_a_step_is_reached_as_often_as_its_count(mean: float) -> None:
    """P(w >= step k) is the Poisson probability of k or more, to the last normal number drawn."""
    steps = np.array(steps_of(mean))
    counts = np.arange(1, len(steps) + 1)
    np.testing.assert_allclose(stats.norm.sf(steps), stats.poisson.sf(counts - 1, mean), rtol=1e-9)
    assert steps[-1] > HIGHEST


@pytest.mark.parametrize("mean", SMALL_MEANS)
def test_steps_count_as_the_sum_does(mean: float) -> None:
    """But for roundings, and beyond 5.4 standard deviations, where the sum knows no more counts."""
    where = backend()
    if not where.jit:
        pytest.skip("counts of the scalar backend are NumPy's")
    normal = np.random.default_rng(4).standard_normal(400_000).astype(np.float32)
    drawn = where.tensor(normal).array
    means = where.tensor(np.full(normal.shape, mean, dtype=np.float32)).array
    summed = np.asarray(poisson_count(means, drawn).numpy())
    stepped = np.asarray(steps_reached(steps_of(float(np.float32(mean))), drawn).numpy())
    assert np.count_nonzero(summed != stepped) <= 20
    assert np.abs(summed - stepped).max() <= 1


def test_a_picture_of_one_mean_is_counted_by_steps_and_any_other_by_sums() -> None:
    """A picture of one small mean has the counts of that mean, whatever way they are made in; one
    that differs anywhere is no such picture."""
    where = backend()
    if not where.jit:
        pytest.skip("counts of the scalar backend are NumPy's")
    camera = load("icx098").resized(24, 32)
    shot = Shot(label="dark", light=(), level=(), exposure_s=0.03, frames=200)
    dark = dataclasses.replace(lit(camera, shot, {}, where), quantity=Quantity.ELECTRONS)
    stream = stream_of(camera, PhotonShot(), shot, 1, range(200), where)
    even = dark.replace(where.tensor(np.full((1, 24, 32), 0.7)))
    uneven = np.full((1, 24, 32), 0.7)
    uneven[0, 5, 7] = 0.8
    found = stream.counts(even).numpy()
    beside = stream.counts(dark.replace(where.tensor(uneven))).numpy()
    assert chi_squared_p(found.ravel(), 0.7) > SIGNIFICANCE
    differ = np.argwhere((found != beside).any(axis=0)).tolist()
    assert [5, 7] in differ
    assert len(differ) <= 3
