"""Verdicts: what is said for which evidence."""

from __future__ import annotations

import dataclasses
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from analysis.gap.camera.base import Base
from analysis.gap.look.families import IMAGE
from analysis.gap.look.observation import Key
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.distance import Distance
from analysis.gap.measure.signature import starts
from analysis.gap.report import NO_GAP, GapReport
from analysis.gap.suspects.beginnings import every_choice
from analysis.gap.verdict import closing, trail, trust
from analysis.gap.verdict import strength as strength_of
from analysis.gap.verdict.closing import accounts, left_as_they_were, lingering, spoilt
from analysis.gap.verdict.confirm import _rivals
from analysis.gap.verdict.later import deserves, earned
from analysis.gap.verdict.verdict import (
    LEAST_SCORE,
    MOST_OF_A_CROWD,
    SEPARATED_BY,
    Choice,
    both,
    choose,
    next_capture,
    p_of_best,
    probabilities,
    telling,
    verdict,
)
from sensor.catalogue import catalogue
from sensor.effects.chroma_subsampling import ChromaSubsampling
from sensor.effects.dropped_frames import DroppedFrames
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.sharpening import Sharpening

BASE = Base(
    channels=("Y",),
    gain_dn_per_e=np.ones(1),
    read_dn2=np.ones(1),
    fpn_dn2=np.ones(1),
    prnu2=np.ones(1),
    black_dn=np.zeros(1),
    dark_e_per_s=0.0,
    shown_e_per_s=0.0,
    dark_spread2=0.0,
    dark_uneven=0.0,
    clamp_e2=0.0,
    arithmetic=0,
    white_balance=None,
    blur_px2=0.0,
    level={},
)


def candidate(name: str, score: float) -> Candidate:
    """A suspect with a score and nothing else."""
    return Candidate(
        effect=catalogue()[name](),
        base=BASE,
        score=score,
        forward=score,
        absorbed=0.0,
        misfit=1.0,
        scenery=None,  # type: ignore[arg-type]
    )


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
        (1, 0.0, 1e-4, 0.99, False, True, "unexplained"),
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
    """A shrunken gap alone is no explanation, and a gap at the floor says nothing by its shrink."""
    gap = dataclasses.replace(
        NO_GAP, p_value_before=before, p_value_after=after, shrink=shrink, at_floor=at_floor
    )
    assert verdict(effects, gap, elsewhere) == word


def test_a_family_that_is_left_as_it_was_is_told() -> None:
    """An effect that closes the total may have nothing to do with what is wrong elsewhere."""

    def far(image: float, rows: float, codes: float) -> Distance:
        by_family = {"mean image": image, "rows": rows, "codes": codes}
        return Distance(total=8.0, by_family=by_family, p_by_family={}, p_value=0.0)

    chances = {"mean image": 0.0, "rows": 1e-40, "codes": 1e-4}
    expected = {"mean image": 800.0, "rows": 100.0, "codes": 100.0}
    few = {"mean image": 800.0, "rows": 10.0, "codes": 10.0}
    before = far(9.0, 5.0, 1.0)
    assert left_as_they_were(chances, before, far(-0.1, 4.8, 1.0), expected) == ("rows",)
    assert left_as_they_were(chances, before, far(-0.1, 1.5, 1.0), expected) == ()
    assert left_as_they_were(chances, before, far(-0.1, 4.8, 1.0), few) == ()


def test_a_family_that_a_model_spoils_is_told() -> None:
    """What is wrong beyond doubt with an effect, and was right without it, is not of its doing."""

    def far(codes: float, chance: float) -> Distance:
        return Distance(
            total=1.0, by_family={"codes": codes}, p_by_family={"codes": chance}, p_value=0.0
        )

    assert spoilt(far(0.7, 1e-3), far(7.7, 1e-90)) == ("codes",)
    assert spoilt(far(57.0, 0.0), far(7.7, 1e-90)) == ()
    assert spoilt(far(0.7, 1e-3), far(7.7, 1e-6)) == ()


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


@pytest.mark.parametrize(
    ("score", "left", "p_value", "tried"),
    [
        (3000.0, 0.8, 0.0, True),  # more than an error of the first one's model
        (500.0, 0.1, 1e-9, True),  # much less, but little is left that it may close
        (500.0, 0.8, 0.0, False),  # nor can it close this much
        (500.0, 0.0, 0.5, False),  # nor is there anything to close
        (50.0, 0.1, 1e-9, False),  # and a weak one closes nothing
    ],
)
def test_which_later_effect_is_tried(
    score: float, left: float, p_value: float, tried: bool
) -> None:
    """Beside a first one of 100,000, of which a model right to a tenth leaves a hundredth."""
    first = candidate("jpeg", 100_000.0)
    now: Any = SimpleNamespace(
        whole=SimpleNamespace(p_value=p_value), held=SimpleNamespace(total=left)
    )
    assert deserves(candidate("hot_pixels", score), first, now) is tried
    absorbed = dataclasses.replace(candidate("hot_pixels", score), absorbed=0.95)
    assert not deserves(absorbed, first, now)


@pytest.mark.parametrize(
    ("score", "after", "ends", "kept"),
    [(3000.0, 0.15, False, True), (3000.0, 0.16, False, False), (500.0, 0.02, False, True),
     (500.0, 0.1, False, False), (500.0, 0.1, True, True)],
)  # fmt: skip
def test_which_later_effect_keeps_its_place(
    score: float, after: float, ends: bool, kept: bool
) -> None:
    """A large one that closes a tenth of G = 0.17; a small one, four fifths or all that is sure."""
    first = candidate("jpeg", 100_000.0)
    now: Any = SimpleNamespace(held=SimpleNamespace(total=0.17))
    step: Any = SimpleNamespace(
        choice=SimpleNamespace(best=candidate("hot_pixels", score)),
        left=SimpleNamespace(held=SimpleNamespace(total=after)),
        ends=ends,
    )
    assert earned(step, now, first) is kept


@pytest.mark.parametrize(
    ("gap", "left", "nothing"),
    [(2.0, 0.05, True), (2.0, 0.2, False), (-0.03, -0.08, False), (0.05, 0.0, False)],
)
def test_near_the_floor_a_search_is_not_ended_by_the_total(
    gap: float, left: float, nothing: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Less than a twentieth is left, of a gap of which a part means something."""
    monkeypatch.setattr(closing, "untouched", lambda before, after: ())
    before, after = (SimpleNamespace(held=SimpleNamespace(total=g)) for g in (gap, left))
    assert closing.nothing_left(before, after) is nothing  # type: ignore[arg-type]


def test_all_choices_of_an_effect_are_made_with_its_strength_as_it_is() -> None:
    chosen = every_choice(Sharpening(amount=0.1, passes=2))
    assert len(chosen) == len(set(chosen)) == 4
    assert {(c.amount, c.passes, c.each_colour) for c in chosen} == {
        (0.1, p, e) for p in (1.0, 2.0) for e in (0.0, 1.0)
    }
    told = every_choice(ChromaSubsampling(mode=1, drawn=1), {"mode": 1.0, "drawn": 1.0})
    assert {(c.mode, c.drawn) for c in told} == {(1.0, 1.0)}
    assert {(c.whole_codes, c.of_whole_codes, c.taken) for c in told} == {
        (w, o, t) for w in (0.0, 1.0) for o in (0.0, 1.0) for t in (0.0, 1.0, 2.0)
    }
    assert every_choice(DroppedFrames(probability=0.3)) == [DroppedFrames(probability=0.3)]


def test_a_lamp_is_looked_for_that_dims_and_one_that_warms() -> None:
    """Wander has no sign and trend has: with the wrong one no amount has both."""
    changes = [effect.change for effect in starts(LampDrift)]
    assert min(changes) < 0 < max(changes)


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


def test_what_lingers_where_most_was_off_is_told() -> None:
    """More than a tenth of the gap of the family that was most off, or much in itself, and beyond
    doubt; or most of it, where that was little.
    """

    def far(codes: float, rows: float, chance: float) -> Distance:
        return Distance(
            total=1.0,
            by_family={"codes": codes, "rows": rows},
            p_by_family={"codes": chance, "rows": 0.0},
            p_value=0.0,
        )

    before = far(256.0, 30.0, 0.0)
    assert lingering(before, far(29.0, 30.0, 1e-90)) == ("codes",)
    assert lingering(before, far(2.9, 30.0, 1e-90)) == ()
    assert lingering(before, far(10.0, 30.0, 1e-90)) == ("codes",)
    assert lingering(before, far(29.0, 30.0, 1e-9)) == ()
    little = far(3.8, 0.5, 1e-20)
    assert lingering(little, far(2.8, 0.4, 1e-13)) == ("codes",)
    assert lingering(little, far(1.8, 0.4, 1e-13)) == ()
    assert lingering(little, far(2.8, 0.4, 1e-5)) == ()


@pytest.mark.parametrize(
    ("names", "place", "most"),
    [
        (["veiling_glare"], 0, 1.0),
        (["row_noise", "black_level_drift"], 0, 1.0),
        (["row_noise", "black_level_drift"], 1, trust.MOST_AGAINST),
        (["row_noise", "veiling_glare"], 1, 1.0),
        (["veiling_glare", "row_noise", "jpeg"], 0, trust.MOST_AGAINST),
        (["veiling_glare", "row_noise", "jpeg"], 2, trust.MOST_AGAINST),
    ],
)
def test_what_a_name_is_given_with_speaks_against_it(
    names: list[str], place: int, most: float
) -> None:
    """Three at once, or two of which a third may be made."""
    assert trust.most_of_several(names, place) == most


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
    ("value", "by", "expected"),
    [(2.0, 0.5, 2.5), (2.0, -1.5, 0.5), (2.0, -2.0, 2.0), (2.0, -3.0, 2.0), (-2.0, 3.0, -2.0)],
)
def test_a_last_step_does_not_take_an_effect_away(value: float, by: float, expected: float) -> None:
    """A strength that vanishes at 0 may become smaller, and never 0 or of the other sign."""
    (strength,) = (
        p for p in catalogue()["black_level_offset"].parameters() if p.name == "offset_e"
    )
    assert strength.identity == 0
    assert strength_of.last_step(strength, value, by) == expected


@pytest.mark.parametrize(("score", "factor"), [(20, 0.4), (40, 0.4), (70, 0.7), (100, 1), (900, 1)])
def test_a_name_of_a_low_score_is_doubted(score: float, factor: float) -> None:
    """By itself it has all that "none of them" leaves: half of such names were right."""
    alone = candidate("row_noise", score)
    (chance,) = probabilities([alone]).values()
    chosen = choose([alone])
    assert chosen is not None
    assert chosen.probability == pytest.approx(factor * chance)


def test_errors_of_a_model_that_does_not_fit_are_as_much_larger() -> None:
    """A family of 8 times the chi-squared that is expected makes errors sqrt(8) times as large, if
    chance does not; the one with the largest share need not be the one that is beyond it."""

    def left(p_value: float) -> Distance:
        by_family = {"codes": 7.0, "level": 11.0, "rows": 0.1}
        chances = {"codes": 1e-12, "level": 0.03, "rows": 0.4}
        return Distance(total=0.2, by_family=by_family, p_by_family=chances, p_value=p_value)

    assert strength_of.birge_ratio(left(1e-10)) == pytest.approx(np.sqrt(8.0))
    assert strength_of.birge_ratio(left(0.2)) == 1.0


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


def test_what_whole_codes_tell_stands_whatever_else_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A family as it was speaks against a fitted effect, and not against bits that are empty."""
    monkeypatch.setattr(trail, "untouched", lambda before, after: ("tails",))
    lost, left = catalogue()["bit_truncation"](), catalogue()["vibration"]()

    def of(*effects: Any) -> Any:
        return SimpleNamespace(models=[SimpleNamespace(effects=effects)], measured=[None, None])

    assert trail.elsewhere(of(left), {"bit_truncation"})
    assert trail.elsewhere(of(lost), set())
    assert not trail.elsewhere(of(lost), {"bit_truncation"})


def against(spread: float, seen: np.ndarray, gap: float, family: str, p_value: float = 0.0) -> Any:
    """A capture whose figures are off by so much, held against a model of some spread."""
    figures = 0 if family == IMAGE else len(seen)
    keys = tuple(
        Key(shot=f"s{k}", lattice="G", family=family, statistic="x") for k in range(figures)
    )
    count = float(len(seen))
    of_twins = SimpleNamespace(
        residuals=np.zeros((16, len(seen))),
        expected=np.array([count]),
        families=np.full(len(seen), family),
    )
    return SimpleNamespace(
        whole=SimpleNamespace(p_value=p_value),
        held=SimpleNamespace(total=gap),
        left=seen / spread,
        rod=SimpleNamespace(
            turned=SimpleNamespace(
                space=SimpleNamespace(keys=keys, log_widths=np.full(len(seen), np.log(spread)))
            ),
            spread=of_twins,
        ),
        case=SimpleNamespace(fit_left=seen, fitting=SimpleNamespace(spread=of_twins)),
    )


@pytest.mark.parametrize(
    ("family", "p_left", "believed"),
    [
        ("frames", 0.0, True),
        ("pattern shape", 0.0, True),
        ("texture", 0.0, False),
        ("texture", 0.5, True),
        (IMAGE, 0.0, False),
        (IMAGE, 0.5, True),
    ],
)
def test_scatter_accounts_for_itself_and_width_does_not(
    family: str, p_left: float, believed: bool
) -> None:
    """Figures that scatter 4 times as wide as the model without a suspect says: its right amount
    takes nothing off by those errors. By its own ones -2 log L falls by 16 - 1 - ln 16 = 12 a
    figure. That is believed of figures of noise and of pattern, and of the picture where nothing is
    left that chance does not make."""
    seen = np.random.default_rng(12).normal(0, 4.0, 400)
    gap = float(np.square(seen).mean()) - 1.0
    found = dataclasses.replace(candidate("row_noise", 900.0), misfit=gap + 1.5)
    now, after = against(1.0, seen, gap, family), against(4.0, seen, 0.0, family, p_left)
    assert accounts(found, now, after) is believed


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_no_strength_is_known_better_than_its_effect(power: float) -> None:
    """An effect a s^r that is seen at z errors has a relative error 1 / z, its strength 1 / (r z):
    as much as the least error for a square, more for what grows in proportion."""
    strength, z = 0.3, 7.0
    around_0 = next(p for p in catalogue()["gamma"].parameters() if p.name == "exponent")
    value = around_0.identity + strength
    of_strength = strength / (power * z)
    assert strength_of.least_error(around_0, value, z**2) <= of_strength * (1 + 1e-12)
    less = strength_of.least_error(around_0, around_0.identity - strength, z**2)
    assert less == pytest.approx(strength / (2 * z))
    assert strength_of.least_error(around_0, value, 0.0) == pytest.approx(strength / 2)


def test_a_full_well_is_known_in_octaves() -> None:
    """From no full well at all it is a million times what the camera holds: a strength is how many
    octaves below that it lies, and a part of those is a factor of the value."""
    full_well = next(p for p in catalogue()["blooming"].parameters() if p.name == "full_well_e")
    value, z = 5000.0, 100.0
    error = strength_of.least_error(full_well, value, z**2)
    octaves = np.log2(full_well.identity / value)
    assert np.log2((value + error) / value) == pytest.approx(octaves / (2 * z), rel=0.05)


def test_a_report_is_strict_json() -> None:
    """No NaN and no infinity leaves the program."""
    gap = dataclasses.replace(NO_GAP, before=float("nan"), shrink=float("inf"))
    document = GapReport(verdict="matched", gap=gap).to_json()
    text = json.dumps(document, allow_nan=False)
    assert json.loads(text)["gap"]["before"] is None
    assert document["format"] == "camtruth-gap/1"
    assert document["next_capture"] is None


def test_a_rival_that_leaves_far_more_than_chance_is_not_tried() -> None:
    """Unless it makes bodies differ: it was fitted in a space of its own, and others' errors say
    nothing of it."""
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
    assert _rivals([best, far, near, drawn]) == [near, drawn]
