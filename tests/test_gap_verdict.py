"""Verdicts: what is said for which evidence."""

from __future__ import annotations

import dataclasses
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from analysis.gap.report import NO_GAP, GapReport
from analysis.gap.search.choice import (
    LEAST_SCORE,
    MOST_OF_A_CROWD,
    Choice,
    both,
    choose,
    p_of_best,
    probabilities,
    telling,
)
from analysis.gap.suspects.separating import SEPARATED_BY, next_capture
from analysis.gap.verdict.word import word_of
from sensor.catalogue import catalogue
from tests.candidates import candidate


@pytest.mark.parametrize(
    ("effects", "before", "after", "shrink", "at_floor", "elsewhere", "word"),
    [
        (0, 0.4, 0.4, 0.0, True, False, "matched"),
        (0, 1e-6, 1e-6, 0.0, False, False, "unexplained"),
        (1, 1e-6, 0.3, 0.97, False, False, "explained"),
        (1, 1e-6, 1e-4, 0.9, False, False, "partly explained"),
        (1, 1e-6, 1e-4, 0.35, False, False, "unexplained"),
        (1, 1e-6, 0.01, -2.0, True, False, "partly explained"),
        (1, 1e-6, 1e-4, 3.0, True, False, "unexplained"),
        (1, 1e-12, 0.02, 0.6, False, False, "partly explained"),
        (1, 1e-3, 0.02, 0.6, False, False, "unexplained"),
        (1, 0.0, 1e-4, 0.99, False, True, "unexplained"),
        (2, 1e-6, 0.3, 0.97, False, False, "explained"),
        (3, 1e-6, 0.3, 0.97, False, False, "unexplained"),
    ],
)
def test_the_word(
    effects: int,
    before: float,
    after: float,
    shrink: float,
    at_floor: bool,
    elsewhere: bool,
    word: str,
) -> None:
    """A shrunken gap alone is no explanation, and a gap at the floor says nothing by its shrink.
    What takes three causes has another one."""
    gap = dataclasses.replace(
        NO_GAP,
        before=1.0,
        p_value_before=before,
        p_value_after=after,
        shrink=shrink,
        at_floor=at_floor,
    )
    assert word_of(effects, gap, elsewhere) == word


@pytest.mark.parametrize(
    ("before", "after", "word"),
    [(1e-30, 2e-4, "partly explained"), (1e-6, 2e-4, "unexplained")],
)
def test_of_a_small_gap_chances_tell_and_not_the_part_that_is_closed(
    before: float, after: float, word: str
) -> None:
    """Frames that were dropped were all that was off beyond doubt, and a hundredth of all figures:
    with the right share of them 0.75 of a gap of 0.09 was closed, and what was left was chance."""
    gap = dataclasses.replace(
        NO_GAP, before=0.09, p_value_before=before, p_value_after=after, shrink=0.75
    )
    assert word_of(1, gap) == word


def test_what_calibration_takes_up_is_no_evidence_by_itself() -> None:
    """A lamp that stands elsewhere, 0.997 of it shading that is free, had a score of 33 by the
    thousandth that was left, in a null of which nothing was significant as a whole. Smear, 0.93 of
    which is shading, was right where glare, of which less is, showed that there is a gap."""
    lamp = dataclasses.replace(candidate("lamp_displacement", 33.0), absorbed=0.997)
    rows = candidate("row_noise", 12.0)
    assert list(telling([lamp, rows], p_of_whole=0.4)) == [rows]
    assert list(telling([lamp, rows], p_of_whole=1e-4)) == [lamp, rows]
    assert list(telling([], p_of_whole=0.4)) == []
    far = dataclasses.replace(lamp, score=130.0)
    assert list(telling([far, rows], p_of_whole=0.4)) == [far, rows]
    smear = dataclasses.replace(candidate("smear", 180.0), absorbed=0.93)
    glare = candidate("veiling_glare", 130.0)
    assert list(telling([smear, glare], p_of_whole=0.4)) == [smear, glare]


def test_a_weak_suspect_is_not_named() -> None:
    """Not even when it is alone."""
    assert choose([candidate("row_noise", LEAST_SCORE - 1)]) is None
    assert choose([]) is None


def test_suspects_within_the_margin_are_named_together() -> None:
    """Two at most beside the best, and no certainty then."""
    found = choose([candidate("image_lag", 62.0), candidate("temporal_filter", 61.0),
                    candidate("jpeg", 20.0)])  # fmt: skip
    assert found is not None
    assert [c.name for c in found.alike] == ["temporal_filter"]
    assert found.probability < 0.7


def test_suspects_within_a_tenth_of_a_large_score_are_named_together() -> None:
    """Signatures are right to a few hundredths, so that 15 in 227 is no reason, and 40 is one."""

    def of(second: float) -> Choice:
        found = choose([candidate("crosstalk", 227.0), candidate("image_lag", second)])
        assert found is not None
        return found

    assert [c.name for c in of(212.0).alike] == ["image_lag"]
    assert of(212.0).probability < 0.9
    assert of(187.0).alike == ()
    assert of(187.0).probability > 0.98


def test_what_calibration_takes_up_is_named_with_what_it_takes_up_as_well() -> None:
    """A lamp that had been moved was ambient light by 14 of 121, which calibration's directions are
    off by. One that it does not take up is told from it as ever, and so is one far behind."""
    light = dataclasses.replace(candidate("ambient_light", 121.0), absorbed=0.998)

    def beside(score: float, absorbed: float) -> Choice:
        other = dataclasses.replace(candidate("lamp_displacement", score), absorbed=absorbed)
        found = choose([light, other])
        assert found is not None
        return found

    assert [c.name for c in beside(107.0, 0.997).alike] == ["lamp_displacement"]
    assert beside(107.0, 0.997).probability <= MOST_OF_A_CROWD
    for found in (beside(107.0, 0.5), beside(50.0, 0.997), beside(10.0, 0.997)):
        assert found.alike == ()
        assert found.probability > MOST_OF_A_CROWD


def test_a_crowd_is_no_answer() -> None:
    """Where more suspects fit than may be named together, none of them is likely."""
    names = ("image_lag", "temporal_filter", "jpeg", "row_noise")
    found = choose([candidate(name, 62.0 - 2 * k) for k, name in enumerate(names)])
    assert found is not None
    assert [c.name for c in found.alike] == ["temporal_filter", "jpeg"]
    assert found.probability <= MOST_OF_A_CROWD


def test_a_pattern_that_lies_elsewhere_is_never_certain() -> None:
    """Not where the other one may not be named either."""
    found = choose([candidate("dust_shadow", 900.0), candidate("smear", 20.0)])
    assert found is not None
    assert found.alike == ()
    assert found.probability <= MOST_OF_A_CROWD


@pytest.mark.parametrize(
    ("rival", "score", "misfit", "beside"),
    [
        ("a drift that leaves 3 % less of chi-squared, as of seed 34", 272.0, 0.97, True),
        ("one that leaves as much", 272.0, 1.0, False),
        ("one of a third of the score", 100.0, 0.97, False),
    ],
)
def test_who_fits_better_is_named_beside_who_has_more_score(
    rival: str, score: float, misfit: float, beside: bool
) -> None:
    drift = dataclasses.replace(candidate("lamp_drift", score), misfit=misfit)
    found = choose([candidate("lamp_flicker", 318.0), drift])
    assert found is not None
    assert (drift in found.alike) is beside, rival
    assert (found.probability <= MOST_OF_A_CROWD) == beside
    # what is never taken for it, and what is held to errors of its own, are no rivals of that kind
    other = dataclasses.replace(candidate("smear", score), misfit=misfit)
    own: Any = dataclasses.replace(drift, model=SimpleNamespace())
    for one in (other, own):
        alone = choose([candidate("lamp_flicker", 318.0), one])
        assert alone is not None
        assert alone.alike == ()


def test_a_clear_suspect_is_nearly_certain() -> None:
    """And probabilities leave room for none of them."""
    scores = probabilities([candidate("row_noise", 200.0), candidate("flicker_noise", 60.0)])
    assert scores["row_noise"] > 0.99
    weak = probabilities([candidate("row_noise", LEAST_SCORE), candidate("jpeg", 2.0)])
    assert sum(weak.values()) < 0.8


def test_a_name_that_little_speaks_for_is_doubted() -> None:
    """Even where nothing speaks for another one; and the more there is, the less."""
    scores = (LEAST_SCORE + 1, 40.0, 70.0, 200.0)
    found = [choose([candidate("row_noise", score)]) for score in scores]
    chances = [one.probability for one in found if one is not None]
    assert chances == sorted(chances)
    assert chances[0] < 0.55
    assert chances[-1] > 0.99


MANY = 1e6
"""Degrees of freedom of an error that is known."""


def test_the_best_of_many_is_less_surprising() -> None:
    """Sidak's correction: forty suspects reach 9.6 by chance about once in thirteen captures, and
    with twenty degrees of freedom for the error of each once in five: Student's t of 3.1 is as rare
    as 2.8 of a normal one."""
    one = p_of_best([candidate("row_noise", 9.6)], MANY)
    forty = p_of_best([candidate("row_noise", 9.6)] + [candidate("jpeg", 0.0)] * 39, MANY)
    assert forty == pytest.approx(1 - (1 - one) ** 40)
    few = p_of_best([candidate("row_noise", 9.6)], 20.0)
    assert few == pytest.approx(2 * stats.t.sf(np.sqrt(9.6), 20.0))
    assert few > 2.5 * one
    assert both(0.01, 0.5) == pytest.approx(1 - 0.99**2)


@pytest.mark.parametrize(
    ("score", "factor"), [(20, 0.4), (40, 0.4), (105, 0.7), (150, 1), (900, 1)]
)
def test_a_name_of_a_low_score_is_doubted(score: float, factor: float) -> None:
    """By itself it has all that "none of them" leaves: half of such names were right."""
    alone = candidate("row_noise", score)
    (chance,) = probabilities([alone]).values()
    chosen = choose([alone])
    assert chosen is not None
    assert chosen.probability == pytest.approx(factor * chance)


def test_every_confusion_names_effects_that_exist() -> None:
    """The table of separating captures speaks of the catalogue."""
    for names, text in SEPARATED_BY:
        assert names <= set(catalogue()), names
        assert text
    assert "dark" in next_capture(["row_noise", "black_level_drift"])


def test_patterns_that_are_drawn_anew_are_named_together() -> None:
    """Dust and slow waves of the response differ by where they lie, which twins do not tell."""
    found = choose([candidate("dust_shadow", 200.0), candidate("adc_dnl", 60.0),
                    candidate("large_scale_prnu", 20.0)])  # fmt: skip
    assert found is not None
    assert [c.name for c in found.alike] == ["large_scale_prnu"]
    assert found.probability < 0.5
    alone = choose([candidate("adc_dnl", 200.0), candidate("large_scale_prnu", 20.0)])
    assert alone is not None
    assert alone.alike == ()


def test_a_report_is_strict_json() -> None:
    """No NaN and no infinity leaves the program."""
    gap = dataclasses.replace(NO_GAP, before=float("nan"), shrink=float("inf"))
    document = GapReport(verdict="matched", gap=gap).to_json()
    text = json.dumps(document, allow_nan=False)
    assert json.loads(text)["gap"]["before"] is None
    assert document["format"] == "camtruth-gap/1"
    assert document["next_capture"] is None
