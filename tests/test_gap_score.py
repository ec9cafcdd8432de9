"""The score of a suspect: what it has where nothing is wrong, and what an effect makes of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from analysis.gap.measure.case import Case, candidate
from analysis.gap.measure.signature import Signature
from analysis.gap.ready.hints import DirectReading
from analysis.gap.suspects.attribute import _by_lost_bits, _untold, too_much
from sensor.catalogue import catalogue
from sensor.effects.row_noise import RowNoise
from tests.candidates import candidate as candidate_of

CAPTURES = 4000
COORDINATES = 12


def scores(of_body: bool, strength: float) -> np.ndarray:
    """Scores of a suspect that has one signature of length 1, at the amount that fits best.

    Args:
        of_body: whether both halves of the frames show the same noise.
        strength: of the effect, in standard errors of what both halves together tell.
    """
    rng = np.random.default_rng(8)
    direction = np.full(COORDINATES, COORDINATES**-0.5)
    each = strength * direction if of_body else strength * direction / np.sqrt(2)
    shown: Any = SimpleNamespace(
        effect=RowNoise(), figures=direction, means=np.empty(0), base=None, scenery=None
    )

    def part(size: float) -> Any:
        """Frames in which the signature has so many standard errors."""
        spread = SimpleNamespace(
            residuals=np.zeros((1, COORDINATES)),
            expected=np.array([float(COORDINATES)]),
        )
        space = SimpleNamespace(vector=lambda figures, means: size * figures)
        return SimpleNamespace(turned=SimpleNamespace(space=space, left=lambda v: v), spread=spread)

    found = []
    for _ in range(CAPTURES):
        first, second = rng.standard_normal((2, COORDINATES))
        lefts = (each + first, each + (first if of_body else second))
        case: Any = SimpleNamespace(
            whole=part(1.0 if of_body else float(np.sqrt(2))),
            fitting=part(1.0),
            scoring=part(1.0),
            fit_left=lefts[0],
            score_left=lefts[1],
        )
        amount = float(direction @ lefts[0])
        found.append(_scored(case, shown, amount))
    return np.array(found)


def _scored(case: Case, shown: Signature, amount: float) -> float:
    return candidate(case, shown, 0.0, amount).score  # type: ignore[arg-type]


def test_a_pattern_that_both_halves_share_is_counted_once() -> None:
    """Score of a null whose noise is the body's: chi-squared of one degree of freedom, so that a
    chance that is read from it is one. At 1 in 10^5 for each of two tests."""
    found = scores(of_body=True, strength=0.0)
    assert stats.kstest(found, stats.chi2(1).cdf).pvalue > 1e-5


def test_noise_in_time_is_held_against_itself() -> None:
    """Amounts a and b of two halves score 4 a b - a^2 - b^2 = u^2 - 3 v^2 of their sum and their
    difference over the root of two: seldom above chi-squared, and -2 in the mean."""
    found = scores(of_body=False, strength=0.0)
    error = np.sqrt(2 * (1 + 9) / CAPTURES)
    assert found.mean() == pytest.approx(-2.0, abs=4 * error)
    above = (found > 4.0).mean()
    assert above < stats.chi2.sf(4.0, 1)


@pytest.mark.parametrize("of_body", [True, False])
def test_an_effect_of_n_standard_errors_scores_n_squared(of_body: bool) -> None:
    """Of either kind, less the 2 that cross-fitting costs and plus the 1 of chance."""
    strength = 8.0
    found = scores(of_body=of_body, strength=strength)
    chance = 1.0 if of_body else -2.0
    error = 2 * strength / np.sqrt(CAPTURES)
    assert found.mean() == pytest.approx(strength**2 + chance, abs=4 * error + 0.2)


@pytest.mark.parametrize(
    ("name", "amount", "out_of_the_question"),
    [
        ("chroma_subsampling", 0.03, True),
        ("chroma_subsampling", 0.5, False),
        ("jpeg", 0.03, False),
        ("row_noise", 0.03, False),
    ],
)
def test_one_step_may_be_many_timestoo_much(
    name: str, amount: float, out_of_the_question: bool
) -> None:
    """A thirtieth of colours at half resolution is no camera; a thirtieth of row noise is one, and
    a codec has a scale of quality to go along."""
    effect = catalogue()[name]()
    found: Any = SimpleNamespace(effect=effect, amount=amount)
    assert too_much(found) is out_of_the_question


@pytest.mark.parametrize(
    ("told", "left"),
    [
        ({}, {"adc_dnl", "bit_truncation", "dust_shadow"}),
        ({"bit_truncation": True}, {"dust_shadow"}),
        ({"bit_truncation": False}, {"adc_dnl", "bit_truncation", "dust_shadow"}),
        ({"dust_shadow": True}, {"adc_dnl", "bit_truncation"}),
    ],
)
def test_what_frames_tell_to_the_last_digit_is_not_fitted_better(
    told: dict[str, bool], left: set[str]
) -> None:
    """Nor is a converter, where they tell that codes are lost; see `_by_lost_bits`."""
    found = {n: candidate_of(n, 100.0) for n in ("adc_dnl", "bit_truncation", "dust_shadow")}
    words = {name: DirectReading(hints={}, exact=exact) for name, exact in told.items()}
    assert {one.name for one in _untold(found, words)} == left


@pytest.mark.parametrize(
    ("told", "without"),
    [
        ({}, {}),
        ({"bit_truncation": True}, {"adc_dnl"}),
        ({"bit_truncation": False}, {}),
        ({"gamma": True}, {}),
    ],
)
def test_beside_bits_that_are_lost_no_converter_has_merit(
    told: dict[str, bool], without: set[str]
) -> None:
    """Its steps may score higher for one lost bit than that does itself."""
    found = {n: candidate_of(n, 100.0) for n in ("adc_dnl", "bit_truncation", "gamma")}
    words = {name: DirectReading(hints={}, exact=exact) for name, exact in told.items()}
    assert _by_lost_bits(found, words) == set(without)
