"""Suspects told apart by their likelihood, each by its own errors."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.calibrate.space import Space
from analysis.gap.measure.case import Candidate, Case
from analysis.gap.suspects import likelihood
from analysis.gap.suspects.likelihood import PER_PARAMETER, judged
from sensor.catalogue import catalogue


def space(spread: np.ndarray, covariance: np.ndarray) -> Space:
    """One channel, one block for each covariance of the shots."""
    shots = covariance.shape[-1]
    return Space(
        keys=(),
        expected_figures=np.zeros(len(spread)),
        expected_means=np.zeros((shots, 1, len(covariance))),
        spread=spread,
        whitening=np.linalg.inv(np.linalg.cholesky(covariance))[None],
        shape=(shots, 1, len(covariance)),
    )


def test_the_determinant_is_that_of_all_coordinates_together() -> None:
    rng = np.random.default_rng(4)
    spread = rng.uniform(0.1, 3.0, 7)
    roots = rng.normal(size=(5, 3, 3))
    covariance = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(3)
    one_by_one = [np.log(spread**2).sum(), np.linalg.slogdet(covariance)[1].sum()]
    assert 2 * space(spread, covariance).log_widths.sum() == pytest.approx(sum(one_by_one))


def test_a_width_that_is_wrong_is_paid_for() -> None:
    """Of normal numbers of width 1, the mean of -2 log L is least for a model of that width: one
    that is s times as wide gains all but 1/s^2 of chi-squared and pays log s^2 for each."""
    rng, count = np.random.default_rng(6), 4000
    seen = rng.normal(size=count)

    def per_figure(width: float) -> float:
        one = space(np.full(count, width), np.ones((1, 1, 1)))
        z = one.figures(seen)
        return float(z @ z + 2 * one.log_widths.sum()) / count

    for width in (0.5, 2.0, 4.0):
        expected = width**-2 - 1 + np.log(width**2)
        error = abs(width**-2 - 1) * np.sqrt(2 / count)
        assert abs(per_figure(width) - per_figure(1.0) - expected) < 4 * error


def suspect(name: str, score: float) -> Candidate:
    return Candidate(
        effect=catalogue()[name](), base=None,  # type: ignore[arg-type]
        score=score, forward=score, absorbed=0.0, misfit=1.0,
        scenery=None,  # type: ignore[arg-type]
    )  # fmt: skip


def test_scores_are_as_far_apart_as_likelihoods(monkeypatch: pytest.MonkeyPatch) -> None:
    """One strength against one strength and three shapes: each shape has its price."""
    deviances = {"row_noise": 100.0, "black_level_drift": 96.0}
    monkeypatch.setattr(likelihood, "deviance", lambda case, found: deviances[found.name])
    monkeypatch.setattr(likelihood, "deviance_without", lambda case: 700.0)
    case: Case = None  # type: ignore[assignment]
    rivals = [suspect("row_noise", 500.0), suspect("black_level_drift", 800.0)]
    row, drift = judged(case, rivals, 0.0)
    assert row.score == 800.0
    assert drift.score == 800.0 - (96.0 + 3 * PER_PARAMETER - 100.0)
    assert judged(case, rivals[:1], 0.0) == rivals[:1]


def test_near_the_floor_scores_stay_what_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(likelihood, "deviance", lambda case, found: pytest.fail("not asked"))
    case: Case = None  # type: ignore[assignment]
    weak = [suspect("row_noise", 50.0), suspect("black_level_drift", 80.0)]
    assert judged(case, weak, 0.0) == weak


def test_one_that_the_errors_of_others_condemn_is_worth_its_likelihood(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where much is left without a suspect, the likeliest is worth what it has over none, whatever
    its score by the errors of others; where none is clearly likelier, scores stay what they are."""
    deviances = {"row_noise": 100.0, "black_level_drift": 900.0}
    monkeypatch.setattr(likelihood, "deviance", lambda case, found: deviances[found.name])
    monkeypatch.setattr(likelihood, "deviance_without", lambda case: 700.0)
    case: Case = None  # type: ignore[assignment]
    row, drift = suspect("row_noise", -5000.0), suspect("black_level_drift", -4000.0)
    first, second = judged(case, [row, drift], 2000.0)
    assert first.score == 700.0 - (100.0 + PER_PARAMETER)
    assert second.score == first.score - (900.0 + 4 * PER_PARAMETER - (100.0 + PER_PARAMETER))
    clear = suspect("black_level_drift", 400.0)
    assert [one.score for one in judged(case, [row, clear], 2000.0)] == [first.score, second.score]
    assert judged(case, [drift], 2000.0) == [drift]
    assert judged(case, [row, drift], 50.0) == [row, drift]
