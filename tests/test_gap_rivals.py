"""Which of several suspects is tried, and which one is taken."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any, cast

import pytest

from analysis.gap.measure.case import Candidate
from analysis.gap.search import confirm
from analysis.gap.search.choice import choose
from analysis.gap.search.confirm import _far_nearer, _rivals, likeliest_step
from analysis.gap.search.step import Step, nearer
from sensor.effects.specular_glare import SpecularGlare
from tests.candidates import candidate


def test_a_rival_that_leaves_far_more_than_chance_is_not_tried() -> None:
    """Unless it makes bodies differ: it was fitted in a space of its own, and others' errors say
    nothing of it. Or the best leaves far more still."""
    best, near, far, drawn = (
        dataclasses.replace(candidate(name, score), misfit=misfit)
        for name, score, misfit in (
            ("gamma", 900.0, 1.2),
            ("jpeg", 500.0, 1.5),
            ("veiling_glare", 600.0, 3.1),
            ("dust_shadow", 400.0, 3.1),
        )
    )
    drawn = dataclasses.replace(drawn, model=SimpleNamespace())
    assert _rivals(best, [best, far, near, drawn]) == [near, drawn]
    led_astray = dataclasses.replace(best, misfit=40.0)
    worse = dataclasses.replace(far, misfit=30.0)
    assert _rivals(led_astray, [led_astray, worse, far]) == [far]


def test_one_that_fits_is_a_rival_of_one_that_does_not() -> None:
    """Whatever its score: where whole frames wander, errors that know of no wander count it as
    nothing. But nothing at all is no suspect, and one that fits needs no other."""

    def one(name: str, score: float, misfit: float) -> Candidate:
        return dataclasses.replace(candidate(name, score), misfit=misfit)

    best, fits = one("flicker_noise", 1300.0, 1.27), one("black_level_drift", 75.0, 1.14)
    likewise, nothing = one("row_noise", 80.0, 1.19), one("interference", 2.0, 1.0)
    assert _rivals(best, [best, likewise, fits, nothing]) == [fits]
    good = dataclasses.replace(best, misfit=1.2)
    assert _rivals(good, [good, likewise, fits, nothing]) == []


def test_of_two_models_that_leave_little_the_one_without_a_bad_family_is_taken() -> None:
    """The total of thousands of figures hides a family that is off; of a large gap it does not."""

    def step(total: float, chance: float) -> Any:
        far = SimpleNamespace(total=total, p_by_family={"rows": chance, "codes": 0.5})
        return SimpleNamespace(left=SimpleNamespace(held=far, whole=far))

    hides, even = step(-0.04, 1e-23), step(0.01, 0.3)
    assert nearer(hides, even) is even
    assert nearer(even, hides) is even
    large, larger = step(0.5, 1e-90), step(0.8, 1e-40)
    assert nearer(larger, large) is large
    assert nearer(even, large) is even


@pytest.mark.parametrize(
    ("total", "chance", "instead"),
    [
        (0.004, 1e-9, True),
        (0.02, 1e-9, False),  # more than a fifth is left
        (0.004, 1e-30, False),  # a family is off beyond doubt, as it is with the best
    ],
)
def test_a_rival_that_leaves_nothing_beyond_doubt_takes_the_place_of_one_that_does(
    total: float, chance: float, instead: bool
) -> None:
    def left(total: float, chance: float) -> Any:
        far = SimpleNamespace(total=total, p_by_family={"rows": chance, "codes": 0.5})
        return SimpleNamespace(held=far, whole=far)

    assert _far_nearer(left(total, chance), left(0.045, 1e-40)) is instead
    assert not _far_nearer(left(total, chance), left(0.045, 1e-3))


LITTLE_OF_IT = 0.3
"""A twentieth of the gap that suspects leave something of."""


def taken(monkeypatch: pytest.MonkeyPatch, leaves: dict[str, tuple[float, float]]) -> Step:
    """The step of the first of some suspects or of a rival, by what each leaves: G and the chance
    of its worst family."""

    def with_it(setting: Any, model: Any, now: Any, choice: Any, watch: Any) -> Any:
        total, chance = leaves[choice.best.name]
        far = SimpleNamespace(total=total, p_by_family={"rows": chance}, p_value=chance)
        left = SimpleNamespace(held=far, whole=far)
        return Step(choice=choice, model=cast(Any, None), left=cast(Any, left), ends=False)

    monkeypatch.setattr(confirm, "with_it", with_it)
    monkeypatch.setattr(confirm, "_is_no_cause", lambda step, now: False)
    monkeypatch.setattr(confirm, "nothing_left", lambda now, left: left.held.total < LITTLE_OF_IT)
    found = [candidate(name, 900.0) for name in leaves]
    choice = choose(found)
    nothing = cast(Any, None)
    step = likeliest_step(nothing, nothing, nothing, found, cast(Any, choice), lambda what: None)
    assert step is not None
    return step


def test_a_rival_that_was_tried_and_leaves_far_more_is_beaten(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And one that leaves as little is not."""
    leaves = {
        "black_level_drift": (0.001, 0.02),
        "flicker_noise": (1.2, 1e-104),
        "row_noise": (0.002, 0.01),
    }
    choice = taken(monkeypatch, leaves).choice
    assert choice.best.name == "black_level_drift"
    assert choice.beaten == {"flicker_noise"}


@pytest.mark.parametrize(
    ("rival", "first"),
    [("veiling_glare", "veiling_glare"), ("dust_shadow", "lateral_chromatic_aberration")],
)
def test_a_rival_that_leaves_far_less_is_taken_unless_it_is_a_drawn_pattern(
    rival: str, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whose width leaves little of whatever is wrong with a picture."""
    leaves = {"lateral_chromatic_aberration": (0.95, 1e-130), rival: (0.06, 1e-11)}
    assert taken(monkeypatch, leaves).choice.best.name == first


@pytest.mark.parametrize(("left", "first"), [(0.29, "veiling_glare"), (0.95, "dust_shadow")])
def test_a_drawn_pattern_with_which_nothing_is_left_needs_that_the_best_leaves_much(
    left: float, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody else's veil left a thirtieth of a gap by ours, and waves of the response nothing."""
    leaves = {"veiling_glare": (left, 1e-15), "dust_shadow": (0.01, 0.2)}
    assert taken(monkeypatch, leaves).choice.best.name == first


@pytest.mark.parametrize(
    ("sigma_px", "dust", "first"),
    [
        (4.6, 37.0, "dust_shadow"),
        (4.6, 30.0, "specular_glare"),  # not half as likely
        (7.0, 37.0, "specular_glare"),
    ],
)
def test_a_patch_of_light_as_small_as_a_grain_of_dust_is_one(
    sigma_px: float, dust: float, first: str
) -> None:
    """Waves, and the patch that is likelier by its score, are named beside the grain."""
    patch = dataclasses.replace(
        candidate("specular_glare", 61.0), effect=SpecularGlare(sigma_px=sigma_px)
    )
    found = choose([patch, candidate("dust_shadow", dust), candidate("large_scale_prnu", 12.0)])
    assert found is not None
    assert found.best.name == first
    if first == "dust_shadow":
        assert [one.name for one in found.alike] == ["large_scale_prnu", "specular_glare"]
        assert found.probability < 0.5


def test_a_drawn_pattern_that_closes_a_gap_alone_is_named_beside_the_other_one() -> None:
    """Which of them it is twins do not tell, whatever their scores."""
    patch, dust, waves = found = [
        candidate("specular_glare", 316.0),
        candidate("dust_shadow", 203.0),
        candidate("large_scale_prnu", 145.0),
    ]
    choice = choose(found)
    assert choice is not None
    assert choice.best is patch
    assert choice.instead(dust, found).alike == (waves,)
    assert choice.instead(candidate("smear", 203.0), found).alike == ()
