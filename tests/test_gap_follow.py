"""The first of two effects is chosen again beside the second."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from analysis.gap.measure.case import Candidate
from analysis.gap.search.choice import TELLS_LITTLE, WEAK, Choice
from analysis.gap.search.follow import (
    DIFFER,
    _chosen_again,
    _done,
    _in_vain,
    _may_be_its_bodies,
)
from tests.candidates import candidate

EXPECTED = 1000.0
"""Chi-squared where nothing is off: G of 0.02 is 20 of it, and a later effect takes 25."""

GAP = 0.077
"""Without any effect."""

CHANCE = 0.9
"""Of what was chosen first."""


def step(best: Candidate, left: float, ends: bool = False) -> Any:
    """By which an effect was added that leaves so much, and `ends` if that is chance."""
    spread = SimpleNamespace(expected=SimpleNamespace(sum=lambda: EXPECTED))
    now = SimpleNamespace(held=SimpleNamespace(total=left), rod=SimpleNamespace(spread=spread))
    return SimpleNamespace(
        choice=Choice(best=best, alike=(), probability=CHANCE, by_name={best.name: CHANCE}),
        left=now,
        model=SimpleNamespace(effects=(best.effect,)),
        ends=ends,
    )


def search(suspects: list[Candidate], chance: float, leaves: float, *, ends: bool = False) -> Any:
    """Finds these beside the second effect, best first, and what is left with the best of them."""

    def made(model: Any, left: Any, candidates: Any, choice: Choice) -> Any:
        return step(choice.best, leaves, ends)

    def beside(model: Any, left: Any, *, kinds: Any) -> Any:
        asked = [one for one in suspects if type(one.effect) in kinds]
        return SimpleNamespace(telling=asked, chance=chance)

    base = SimpleNamespace(held=SimpleNamespace(total=GAP))
    kinds = [type(one.effect) for one in suspects]
    return SimpleNamespace(base=base, beside=beside, step=made, kinds=kinds)


FIRST, OTHER = "crosstalk", "charge_transfer_inefficiency"


@pytest.mark.parametrize(
    ("what", "scores", "chance", "leaves", "taken"),
    [
        ("another explains more and leaves no more", (170.0, 220.0), 1e-6, -0.04, True),
        ("it leaves a little more, by less than a later effect takes", (170.0, 220.0), 1e-6,
         -0.02, True),
        ("it leaves more", (170.0, 220.0), 1e-6, 0.01, False),
        ("the first still explains most", (220.0, 170.0), 1e-6, -0.04, False),
        ("chance leaves as much", (170.0, 220.0), 0.3, -0.04, False),
    ],
)  # fmt: skip
def test_the_first_of_two_effects_is_chosen_again(
    what: str, scores: tuple[float, float], chance: float, leaves: float, taken: bool
) -> None:
    """Crosstalk was nearest to what a nonlinearity and a charge transfer did together; beside the
    nonlinearity the transfer is nearer."""
    suspects = [candidate(FIRST, scores[0]), candidate(OTHER, scores[1])]
    suspects.sort(key=lambda one: one.score, reverse=True)
    first, second = candidate(FIRST, 620.0), candidate("nonlinearity", 310.0)
    again = _chosen_again(
        search(suspects, chance, leaves), step(first, 0.01), step(second, -0.025),
        step(second, 0.008),
    )  # fmt: skip
    assert (again is not None and again.choice.best.name == OTHER) is taken, what


def test_what_leaves_chance_alone_is_taken_whatever_the_first_left() -> None:
    """Of an effect that makes bodies differ G is lower and says less than what chance has of it."""
    first, second = candidate(FIRST, 620.0), candidate("nonlinearity", 310.0)
    found = search([candidate(OTHER, 220.0)], 1e-6, 0.045, ends=True)
    for ends in (True, False):
        again = _chosen_again(
            found, step(first, 0.01), step(second, -0.05, ends), step(second, 0.008)
        )
        assert (again is not None) is not ends


@pytest.mark.parametrize("better", [True, False])
def test_where_nothing_is_left_the_first_effect_gives_way_to_what_fits_better(better: bool) -> None:
    """Scores alone tell little of two that fit: beside a converter's steps a veil scored more than
    a gamma, which left less."""
    other = dataclasses.replace(candidate(OTHER, 197.0), misfit=0.96 if better else 1.01)
    own = dataclasses.replace(candidate(FIRST, 160.0), misfit=0.97)
    first, second = candidate(FIRST, 535.0), candidate("nonlinearity", 310.0)
    again = _chosen_again(
        search([other, own], 1e-6, -0.05, ends=True),
        step(first, 0.01),
        step(second, -0.05, True),
        step(second, -0.01),
    )
    assert (again is not None) is better


@pytest.mark.parametrize(
    ("what", "second_ends", "ends", "taken"),
    [
        ("its strength was led astray, and is right beside the second", False, True, True),
        ("it leaves something again", False, False, False),
        ("it is right as it is", True, True, False),
    ],
)
@pytest.mark.parametrize("by_itself", [0.008, 0.1])
def test_the_first_effect_is_fitted_again_beside_the_second(
    what: str, second_ends: bool, ends: bool, taken: bool, by_itself: float
) -> None:
    """Whether the second one alone leaves more than there was or less; nobody else can do what the
    first does where it leaves more, so that nobody else is asked, and it is as probable as it was.
    """
    suspects = [candidate(FIRST, 620.0), candidate(OTHER, 170.0)]
    first, second = candidate(FIRST, 620.0), candidate("nonlinearity", 310.0)
    again = _chosen_again(
        search(suspects, 1e-6, 0.0, ends=ends),
        step(first, 0.01),
        step(second, 0.0, second_ends),
        step(second, by_itself),
    )
    assert (again is not None) is taken, what
    if again is not None:
        assert again.choice.best.name == FIRST
        assert again.choice.probability == CHANCE or by_itself < GAP


def test_beside_a_second_effect_that_alone_makes_things_worse_nobody_else_is_asked() -> None:
    nobody = search([candidate(OTHER, 220.0)], 1e-6, -0.04, ends=True)
    first, second = candidate(FIRST, 620.0), candidate("nonlinearity", 310.0)
    for ends in (False, True):
        both = step(second, 0.0, ends)
        assert _chosen_again(nobody, step(first, 0.01), both, step(second, 0.1)) is None


def test_what_cannot_be_named_beside_the_second_changes_nothing() -> None:
    nobody = search([], 1e-6, 0.0)
    first, second = candidate(FIRST, 620.0), candidate("nonlinearity", 310.0)
    assert _chosen_again(nobody, step(first, 0.01), step(second, 0.0), step(second, 0.0)) is None


@pytest.mark.parametrize(
    ("what", "effects", "misfit", "left", "vain"),
    [
        ("two that close half of a large gap", 2, 13.0, 15.0, True),
        ("two that close most of it", 2, 5.0, 5.0, False),
        ("one: a second may close the rest", 1, 13.0, 15.0, False),
        ("near the camera: what they leave is told well", 2, 2.0, 15.0, False),
    ],
)
def test_no_third_effect_is_looked_for_where_two_leave_too_much_to_be_named(
    what: str, effects: int, misfit: float, left: float, vain: bool
) -> None:
    """With a third it would be unexplained, and without one too."""
    steps: Any = [
        SimpleNamespace(
            left=SimpleNamespace(
                case=SimpleNamespace(misfit=misfit), held=SimpleNamespace(total=left)
            )
        )
    ] * effects
    base: Any = SimpleNamespace(held=SimpleNamespace(total=30.0), floor=0.0)
    assert _in_vain(steps, base) is vain, what


def test_nothing_stands_out_where_bodies_differ_by_a_few_photosites() -> None:
    """A model that fits, with bodies so different, is the last: no suspect is even asked."""
    one: Any = step(candidate(FIRST, 100.0), left=-0.1, ends=True)
    one.left.held_error = 1.1 * DIFFER
    base: Any = SimpleNamespace()
    asked: Any = None  # what is asked of nobody fails
    assert _done([one], base, asked)
    one.left.held_error = 0.9 * DIFFER
    one.left.case = SimpleNamespace()
    with pytest.raises(TypeError, match="not iterable"):
        _done([one], base, asked)


@pytest.mark.parametrize(
    ("what", "chance", "gap", "score", "more"),
    [
        ("a weak name for hardly any gap", 0.01, -0.13, 57.0, True),
        ("no name for hardly any gap", 0.01, 0.02, None, True),
        ("chance leaves as much", 0.2, -0.13, 14.0, False),
        ("a gap that tells", 0.01, 1.1 * TELLS_LITTLE, 57.0, False),
        ("a name that bodies cannot make", 0.01, 0.02, 1.1 * WEAK[1], False),
    ],
)
def test_more_bodies_are_simulated_before_little_is_called_something(
    what: str, chance: float, gap: float, score: float | None, more: bool
) -> None:
    suspects = () if score is None else (candidate(FIRST, score),)
    look: Any = SimpleNamespace(chance=chance, telling=suspects)
    base: Any = SimpleNamespace(held=SimpleNamespace(total=gap))
    assert _may_be_its_bodies(look, base) is more, what
