"""Figures that rise and fall together count once."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.look.observation import Key
from analysis.gap.measure.in_common import LEAST_OWN, correlation, correlations

TWINS, SHOTS, PLACES = 12, 6, 8

KEYS = [
    Key(shot=f"shot-{s}", lattice="G", family="neighbours", statistic=f"lag {p}")
    for s in range(SHOTS)
    for p in range(PLACES)
]


def twins(seed: int, part: float) -> np.ndarray:
    """Standardized figures of which a shot's have so much of their variance in common."""
    rng = np.random.default_rng(seed)
    own = rng.standard_normal((TWINS, SHOTS, PLACES))
    shared = rng.standard_normal((TWINS, SHOTS, 1))
    return np.asarray(np.sqrt(1 - part) * own + np.sqrt(part) * shared).reshape(TWINS, -1)


def told(seed: int, part: float) -> np.ndarray | None:
    samples = twins(seed, part).reshape(-1, PLACES)
    return correlation(samples, (TWINS - 1) * SHOTS)


@pytest.mark.parametrize("seed", range(10))
def test_independent_figures_have_nothing_in_common(seed: int) -> None:
    """The largest eigenvalue of 72 samples in 8 places is at the edge in the mean; one that is
    beyond it by chance is so by little."""
    found = told(seed, 0.0)
    assert found is None or np.linalg.slogdet(found)[1] > -1.5


@pytest.mark.parametrize("part", [0.5, 0.9])
def test_a_shared_part_is_found(part: float) -> None:
    """A correlation is known to (1 - part^2) / sqrt(66), and the mean of 28 pairs no better, as
    one shared number makes all of them: at 4 standard errors."""
    found = told(3, part)
    assert found is not None
    pairs = found[~np.eye(PLACES, dtype=bool)]
    assert pairs.mean() == pytest.approx(part, abs=4 * (1 - part**2) / np.sqrt(66))
    assert np.diag(found) == pytest.approx(1.0)


def test_every_shot_has_its_own() -> None:
    """The same for all shots with the same figures, nothing between two of them; a figure half of
    whose error no twin shows has half as much in common with another like it."""
    part = np.ones(SHOTS * PLACES)
    part[PLACES:] = 0.5
    made = list(correlations(KEYS, twins(3, 0.9), part))
    assert [list(place) for place, _ in made] == [
        list(range(s * PLACES, (s + 1) * PLACES)) for s in range(SHOTS)
    ]
    whole, half = made[0][1], made[1][1]
    assert whole == pytest.approx(told(3, 0.9))
    assert half - np.eye(PLACES) == pytest.approx(0.5 * (whole - np.eye(PLACES)))


def test_a_figure_that_never_moved_stands_by_itself() -> None:
    samples = twins(3, 0.9).reshape(-1, PLACES)
    samples[:, 2] = 0.0
    found = correlation(samples, (TWINS - 1) * SHOTS)
    assert found is not None
    assert found[2] == pytest.approx(np.eye(PLACES)[2])


def test_figures_that_are_one_keep_something_of_their_own() -> None:
    """A correlation of 1 would make a determinant of 0, whatever a capture shows."""
    found = told(4, 1.0)
    assert found is not None
    assert np.linalg.slogdet(found)[1] > PLACES * np.log(LEAST_OWN)


def test_what_is_in_common_counts_once() -> None:
    """Chi-squared of p figures that a shared part r moved by a standard error each is p without
    their correlation and p / (1 + (p - 1) r) with it; log det is log(1 + (p - 1) r) +
    (p - 1) log(1 - r) instead of 0. 66 samples tell what is own to sqrt(2 / 66) in each of 7
    directions, and what is shared to as much at once for all 7: at 4 standard errors."""
    r = 0.9
    found = told(5, r)
    assert found is not None
    moved = np.ones(PLACES)
    chi2 = moved @ np.linalg.solve(found, moved)
    assert chi2 == pytest.approx(PLACES / (1 + (PLACES - 1) * r), rel=0.1)
    expected = np.log(1 + (PLACES - 1) * r) + (PLACES - 1) * np.log(1 - r)
    assert np.linalg.slogdet(found)[1] == pytest.approx(
        expected, abs=4 * np.sqrt((7 + 7**2) * 2 / 66)
    )
