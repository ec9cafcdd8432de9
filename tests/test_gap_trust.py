"""How far a name is believed."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from analysis.gap.camera.base import Body
from analysis.gap.search.choice import Choice, choose
from analysis.gap.verdict import caps, trust
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.effects.crosstalk import Crosstalk
from sensor.effects.specular_glare import SpecularGlare
from sensor.effects.veiling_glare import VeilingGlare
from tests.candidates import candidate


def test_a_name_has_no_rival_in_one_that_is_named_with_it() -> None:
    """0.52 of interference, 0.40 of charge transfer and 0.08 of crosstalk: where charge transfer is
    named as well, interference has 0.52 of the 0.60 that is left."""
    first = choose([candidate("interference", 40.0), candidate("crosstalk", 36.0)])
    assert first is not None
    first = dataclasses.replace(
        first,
        probability=0.52,
        by_name={"interference": 0.52, "charge_transfer_inefficiency": 0.4, "crosstalk": 0.08},
    )
    later = choose([candidate("charge_transfer_inefficiency", 200.0)])
    assert later is not None

    def beside(*choices: Choice) -> float:
        return trust.beside(first, choices)

    assert beside(first) == pytest.approx(0.52)
    assert beside(first, later) == pytest.approx(0.52 / 0.6)
    certain = dataclasses.replace(first, probability=0.9)
    assert trust.beside(certain, (certain, later)) == 1.0
    # a drawn pattern is doubted for what it is
    grains = dataclasses.replace(first, best=candidate("dust_shadow", 40.0), probability=0.45)
    assert trust.beside(grains, (grains, later)) == 0.45


@pytest.mark.parametrize(
    ("names", "place", "most"),
    [
        (["veiling_glare"], 0, 1.0),
        (["row_noise", "black_level_drift"], 0, caps.MOST_AGAINST),
        (["row_noise", "veiling_glare"], 0, 1.0),
        (["row_noise", "black_level_drift"], 1, caps.MOST_AGAINST),
        (["row_noise", "veiling_glare"], 1, 1.0),
    ],
)
def test_what_a_name_is_given_with_speaks_against_it(
    names: list[str], place: int, most: float
) -> None:
    """Two of which a third may be made."""
    assert caps.most_of_several(names, place) == most


@pytest.mark.parametrize(
    ("before", "left", "place", "most"),
    [
        (384.0, [0.126, -0.03], 1, caps.MOST_AGAINST),
        (384.0, [0.126, -0.03], 0, 1.0),
        (384.0, [0.9, -0.03], 1, 1.0),
        (28.0, [0.02, -0.01], 1, 1.0),
    ],
)
def test_a_thousandth_of_a_gap_is_no_sure_second_cause(
    before: float, left: list[float], place: int, most: float
) -> None:
    """The model of the first one is off by as much, where that can be seen at all."""
    assert caps.most_of_a_remainder(before, left, place) == most


@pytest.mark.parametrize(
    ("chances", "alike", "none"),
    [
        ([0.41], [[]], True),
        ([0.55], [[]], False),
        ([0.42], [["flicker_noise"]], False),
        ([0.2], [["specular_glare"]], True),
        ([0.45, 0.3], [[], []], True),
        ([0.45, 0.3], [[], ["row_noise"]], False),
        ([0.85, 0.3], [[], []], False),
    ],
)
def test_names_of_which_none_is_likely_explain_nothing(
    chances: list[float], alike: list[list[str]], none: bool
) -> None:
    """Slow waves that were withheld left something of a gap and took the name of dust (0.41). A
    drift of the black level that flicker noise resembles is one of both."""
    choices = []
    for names in alike:
        best = choose([candidate("black_level_drift", 40.0)])
        assert best is not None
        beside = tuple(candidate(name, 38.0) for name in names)
        choices.append(dataclasses.replace(best, alike=beside))
    assert trust.likelier_none(choices, chances) == none


@pytest.mark.parametrize(
    ("score", "left", "most"),
    [
        (102.0, ((), ()), caps.MOST_AGAINST),
        (107.0, ((), ()), 1.0),
        (102.0, (("rows",), ()), 1.0),
        (102.0, (("rows",), ("rows",)), caps.MOST_AGAINST),
    ],
)
def test_a_later_name_that_is_a_fiftieth_of_the_first_closes_what_that_one_left_alone(
    score: float,
    left: tuple[tuple[str, ...], tuple[str, ...]],
    most: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a score of 5270 that is 105. By rows alone it is told whatever the size."""
    monkeypatch.setattr(caps, "untouched", lambda base, one, worth: left[one - 1])
    chosen = [
        SimpleNamespace(best=candidate("lens_distortion", 5270.0)),
        SimpleNamespace(best=candidate("row_noise", score)),
    ]
    found: Any = SimpleNamespace(choices=chosen, measured=(0, 1, 2))
    assert caps.most_beside_a_larger(found, 1) == most
    assert caps.most_beside_a_larger(found, 0) == 1.0


@pytest.mark.parametrize(
    ("effect", "most"),
    [
        (SpecularGlare(sigma_px=60.0), caps.MOST_AGAINST),
        (SpecularGlare(sigma_px=50.0), 1.0),
        (SpecularGlare(sigma_px=7.0), 1.0),
        (SpecularGlare(sigma_px=6.9), caps.MOST_AGAINST),
        (VeilingGlare(), 1.0),
        (Crosstalk(along_rows=0.6, to_corners=0.12), 1.0),
        (Crosstalk(along_rows=0.69), caps.MOST_AGAINST),
        (Crosstalk(along_rows=0.31), caps.MOST_AGAINST),
        (Crosstalk(to_corners=0.25), caps.MOST_AGAINST),
    ],
)
def test_a_patch_or_a_crosstalk_of_an_unlikely_shape_is_doubted(
    effect: Effect, most: float
) -> None:
    """Of 120 rows 0.45 are 54: a patch is as wide as the picture, or as narrow as a grain. Charge
    spreads to all sides, and to corners a third as much at most."""
    body = Body(height=120, width=160, pixels="rgb8", bits=8, cfa="RGGB", name="one")
    assert caps.most_of_a_shape(effect, body) == most


def test_noise_of_rows_that_leaves_something_may_be_another_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each has its own spectrum: what is left of one speaks for the next, if that has a part of its
    score and was not tried in vain. Where nothing is left, and of other effects, a name is
    believed."""
    monkeypatch.setattr(caps, "against", lambda before, after: ())

    def most(
        name: str, word: str, rival: str = "row_noise", score: float = 300.0, beaten: str = ""
    ) -> float:
        best = candidate(name, 900.0)
        found: Any = SimpleNamespace(
            choices=(SimpleNamespace(best=best, beaten=frozenset({beaten})),),
            candidates=(best, candidate(rival, score)),
            measured=(None, None),
        )
        return caps.most_of_a_name(word, found)

    assert most("flicker_noise", "partly explained") == caps.MOST_AGAINST < trust.LIKELIER
    assert most("flicker_noise", "partly explained", score=200.0) == caps.MOST_IN_PART
    assert most("flicker_noise", "partly explained", "interference") == caps.MOST_IN_PART
    assert most("flicker_noise", "partly explained", beaten="row_noise") == caps.MOST_IN_PART
    assert most("flicker_noise", "explained") == caps.MOST_CERTAIN
    assert most("interference", "partly explained") == caps.MOST_IN_PART


@pytest.mark.parametrize(
    ("name", "left", "witness", "most"),
    [
        ("lateral_chromatic_aberration", 0.35, "texture", caps.MOST_BUT_TEXTURE),
        ("lateral_chromatic_aberration", 0.95, "texture", caps.MOST_AGAINST),  # much is left
        ("lateral_chromatic_aberration", 0.35, "rows", caps.MOST_AGAINST),  # optics move no rows
        ("large_scale_prnu", 0.35, "texture", caps.MOST_AGAINST),  # which has a texture of its own
        ("vibration", 0.35, "frames", caps.MOST_BUT_TEXTURE),  # sites see more or less of an edge
        ("lens_distortion", 0.35, "frames", caps.MOST_AGAINST),  # as they do in every frame
    ],
)
def test_edges_that_lie_a_little_elsewhere_leave_a_texture(
    name: str, left: float, witness: str, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of an effect that moves the picture, and closes nine tenths of the gap."""
    monkeypatch.setattr(caps, "against", lambda before, after: (witness,))
    best = dataclasses.replace(candidate(name, 900.0), effect=catalogue()[name]())
    totals = [SimpleNamespace(held=SimpleNamespace(total=total)) for total in (5.3, left)]
    found: Any = SimpleNamespace(
        choices=(SimpleNamespace(best=best, beaten=frozenset()),),
        candidates=(best,),
        measured=totals,
    )
    assert caps.most_of_a_name("partly explained", found) == most


def test_lost_bits_are_seen_whatever_else_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other names are likelier not than so where something speaks against them beyond doubt."""
    monkeypatch.setattr(caps, "against", lambda before, after: ("codes",))

    def most(name: str, told: dict[str, float] | None) -> float:
        best = dataclasses.replace(candidate(name, 900.0), told=told)
        found: Any = SimpleNamespace(
            choices=(SimpleNamespace(best=best),), candidates=(best,), measured=(None, None)
        )
        return caps.most_of_a_name("partly explained", found)

    assert most("bit_truncation", {}) == caps.MOST_IN_PART
    assert most("bit_truncation", None) == caps.MOST_AGAINST  # only fitted
    assert most("white_balance", {}) == caps.MOST_AGAINST


def test_no_name_is_surer_than_the_one_it_was_found_beside() -> None:
    assert trust.no_surer([0.34, 0.75], [False, False]) == [0.34, 0.34]
    assert trust.no_surer([0.34, 0.75], [False, True]) == [0.34, 0.75]  # frames tell that
    assert trust.no_surer([0.9, 0.75, 0.2], 3 * [False]) == [0.9, 0.75, 0.2]
    assert trust.no_surer([], []) == []


@pytest.mark.parametrize(
    ("left", "little", "pair"),
    [
        ((11.0, 6.1, 0.1), True, True),
        ((11.0, 6.1, 0.1), False, False),  # a family speaks against both
        ((11.0, 2.2, 0.1), True, True),  # the second one closes nearly all that the first left
        ((11.0, 2.2, 0.5), True, False),  # and does not here
        ((11.0, 1.1, 0.1), True, False),  # the second one is a remainder of the first
        ((11.0, 9.0, 0.1), True, False),  # the first one closes little
        ((11.0, 0.1), True, False),
    ],
)
def test_two_that_need_each_other_and_leave_nothing_are_a_pair(
    left: tuple[float, ...], little: bool, pair: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each closes a quarter of the gap at least."""
    monkeypatch.setattr(trust, "nothing_left", lambda base, both: little)
    measured: Any = [SimpleNamespace(held=SimpleNamespace(total=total)) for total in left]
    assert trust.is_a_pair(measured) is pair
    assert trust.LIKELIER < trust.IN_PAIR < trust.LATER


@pytest.mark.parametrize(
    ("names", "forward", "left", "most"),
    [
        ("jpeg crosstalk", (900.0, 170.0), 2.1, trust.OF_ONE_THAT_STANDS_OUT),
        ("jpeg crosstalk", (900.0, 190.0), 2.1, 0.0),  # the next one closes a fifth of that
        ("jpeg crosstalk", (900.0, 170.0), 2.3, 0.0),  # a fifth is left
        ("dust_shadow large_scale_prnu", (900.0, 850.0), 2.1, 0.45),  # which stay doubtful
    ],
)
def test_a_first_effect_that_stands_out_is_named_whatever_is_left(
    names: str, forward: tuple[float, float], left: float, most: float
) -> None:
    """Of G 11 it closes four fifths, and nobody else a fifth of that."""
    candidates = [candidate(*one) for one in zip(names.split(), forward, strict=True)]
    choice = choose(candidates)
    assert choice is not None
    model = SimpleNamespace(
        effects=(candidates[0].effect,), scenery=SimpleNamespace(body=SimpleNamespace())
    )
    lead: Any = SimpleNamespace(
        choices=(choice,),
        candidates=candidates,
        models=(model,),
        measured=[SimpleNamespace(held=SimpleNamespace(total=total)) for total in (11.0, left)],
    )
    setting: Any = None
    assert trust.stands_out(lead, setting) == most


def test_what_was_tried_and_leaves_far_more_is_no_rival_of_what_stands_out() -> None:
    """Shared colours leave 0.4 of G 50; a vibration scored more than half as much and leaves 14."""
    candidates = [candidate("chroma_subsampling", 900.0), candidate("vibration", 500.0)]
    choice = choose(candidates)
    assert choice is not None
    model = SimpleNamespace(
        effects=(candidates[0].effect,), scenery=SimpleNamespace(body=SimpleNamespace())
    )

    def of(beaten: frozenset[str]) -> float:
        lead: Any = SimpleNamespace(
            choices=(dataclasses.replace(choice, beaten=beaten),),
            candidates=candidates,
            models=(model,),
            measured=[SimpleNamespace(held=SimpleNamespace(total=total)) for total in (50.0, 0.4)],
        )
        setting: Any = None
        return trust.stands_out(lead, setting)

    assert of(frozenset()) == 0.0
    assert of(frozenset({"vibration"})) == trust.OF_ONE_THAT_STANDS_OUT


def test_what_little_is_closed_names_nobody() -> None:
    """Near the floor every suspect may close all of a gap."""
    best = candidate("jpeg", 900.0)
    choice = choose([best])
    measured = [SimpleNamespace(held=SimpleNamespace(total=total)) for total in (0.2, 0.0)]
    lead: Any = SimpleNamespace(choices=(choice,), candidates=[best], measured=measured)
    setting: Any = None
    assert trust.stands_out(lead, setting) == 0.0


@pytest.mark.parametrize(
    ("word", "before", "p_after", "count", "factor"),
    [
        ("explained", 0.05, 0.3, 1, 1.0),
        ("explained", 0.05, 0.3, 2, 1.0),
        ("partly explained", 0.05, 1e-5, 1, trust.DOUBT),
        ("partly explained", 0.05, 1e-5, 2, trust.DOUBT),
        ("partly explained", 0.05, 0.02, 1, trust.LATER),
        ("partly explained", 0.2, 1e-9, 1, trust.DOUBT),
        ("partly explained", 0.2, 1e-5, 1, 1.0),
        ("partly explained", 5.0, 1e-9, 1, 1.0),
    ],
)
def test_of_a_small_gap_of_which_something_is_left_no_name_is_sure(
    word: Any, before: float, p_after: float, count: int, factor: float
) -> None:
    """An offset of the black level was a white balance with 0.85: of G 0.034 it left 0.001, and a
    chance of 4e-5."""
    gap: Any = SimpleNamespace(before=before, p_value_after=p_after)
    assert trust.by_what_is_left(word, gap, 1.0, 0, count) == pytest.approx(factor)


@pytest.mark.parametrize(("told", "sure"), [({}, True), (None, False)])
def test_bits_that_frames_tell_are_no_half_of_anything(told: dict | None, sure: bool) -> None:
    found = dataclasses.replace(candidate("bit_truncation", 500.0), told=told)
    assert caps.lost_bits(found) is sure
    assert not caps.lost_bits(dataclasses.replace(candidate("jpeg", 500.0), told=told))
