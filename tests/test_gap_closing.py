"""What a model closes of a gap, and which effect is added next."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from analysis.gap.look.families import IMAGE
from analysis.gap.look.observation import Key
from analysis.gap.measure.distance import Distance
from analysis.gap.search import closing, trail
from analysis.gap.search.closing import accounts, left_as_they_were, lingering, spoilt, too_wide
from analysis.gap.search.later import deserves, earned, instead_of_it, leads
from sensor.catalogue import catalogue
from tests.candidates import candidate


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


def seen(total: float, rows: float, p_value: float = 0.0) -> Any:
    """A capture against a model, of which the family of rows is off beyond doubt at a G of 5."""
    far = Distance(
        total=total,
        by_family={"rows": rows},
        p_by_family={"rows": 1e-40 if rows > 1.0 else 0.1},
        p_value=p_value,
    )
    spread = SimpleNamespace(names=("rows",), expected=[100.0])
    return SimpleNamespace(held=far, whole=far, rod=SimpleNamespace(spread=spread))


WITHOUT = seen(9.0, 5.0)


@pytest.mark.parametrize(
    ("score", "left", "p_value", "rows", "tried"),
    [
        (3000.0, 0.8, 0.0, 0.0, True),  # more than an error of the first one's model
        (500.0, 0.1, 1e-9, 0.0, True),  # much less, but little is left that it may close
        (500.0, 0.8, 0.0, 0.0, False),  # nor can it close this much
        (500.0, 0.8, 0.0, 4.9, True),  # unless what is left was never the first one's
        (500.0, 0.0, 0.5, 0.0, False),  # nor is there anything to close
        (50.0, 0.1, 1e-9, 4.9, False),  # and a weak one closes nothing
    ],
)
def test_which_later_effect_is_tried(
    score: float, left: float, p_value: float, rows: float, tried: bool
) -> None:
    """Beside a first one of 100,000, of which a model right to a tenth leaves a hundredth."""
    first = candidate("jpeg", 100_000.0)
    now = seen(left, rows, p_value)
    assert deserves(candidate("hot_pixels", score), first, WITHOUT, now) is tried
    # what the first one cannot have left of what it did is no remainder of it
    assert deserves(candidate("hot_pixels", score), first, WITHOUT, now, apart=51.0)
    absorbed = dataclasses.replace(candidate("hot_pixels", score), absorbed=0.95)
    assert deserves(absorbed, first, WITHOUT, now) is (score > 2000.0)
    assert deserves(absorbed, candidate("jpeg", 100.0), WITHOUT, now) is (score > 60.0)
    # dust shades a picture as a lamp might, and twins do not know where
    assert not deserves(absorbed, candidate("dust_shadow", 100.0), WITHOUT, now)


@pytest.mark.parametrize(
    ("first", "later", "p_value", "tried"),
    [
        ("dust_shadow", "specular_glare", 0.5, False),
        ("large_scale_prnu", "dust_shadow", 0.5, False),
        ("dust_shadow", "specular_glare", 0.01, True),  # something is left
        ("dust_shadow", "hot_pixels", 0.5, True),
        ("specular_glare", "dust_shadow", 0.5, True),  # the patch has a place, and has done its own
    ],
)
def test_beside_a_drawn_pattern_that_leaves_nothing_one_more_bump_is_its_own(
    first: str, later: str, p_value: float, tried: bool
) -> None:
    now = seen(0.04, 0.0, p_value)
    assert deserves(candidate(later, 174.0), candidate(first, 200.0), WITHOUT, now) is tried


@pytest.mark.parametrize(
    ("score", "after", "rows", "ends", "kept"),
    [
        (3000.0, 0.15, (0.0, 0.0), False, True),
        (3000.0, 0.16, (0.0, 0.0), False, False),
        (500.0, 0.02, (0.0, 0.0), False, True),
        (500.0, 0.1, (0.0, 0.0), False, False),
        (500.0, 0.1, (0.0, 0.0), True, True),
        (500.0, 0.1, (4.9, 0.5), False, True),
        (500.0, 0.1, (4.9, 4.5), False, False),
    ],
)
def test_which_later_effect_keeps_its_place(
    score: float, after: float, rows: tuple[float, float], ends: bool, kept: bool
) -> None:
    """A large one that closes a tenth of G = 0.17; a small one that closes four fifths, all that is
    sure, or all that the first one left as it was."""
    first = candidate("jpeg", 100_000.0)
    step: Any = SimpleNamespace(
        choice=SimpleNamespace(best=candidate("hot_pixels", score)),
        left=seen(after, rows[1]),
        ends=ends,
    )
    assert earned(step, WITHOUT, seen(0.17, rows[0]), first) is kept
    # of one that calibration takes up no size is enough
    absorbed = dataclasses.replace(candidate("hot_pixels", score), absorbed=0.95)
    step.choice.best = absorbed
    now = seen(0.17, rows[0])
    assert earned(step, WITHOUT, now, first) is (kept and not score > 2000.0)


@pytest.mark.parametrize(
    ("absorbed", "left", "instead"), [(0.95, 4.0, True), (0.95, 5.0, False), (0.5, 4.0, False)]
)
def test_what_calibration_takes_up_and_closes_a_gap_alone_is_no_second_cause(
    absorbed: float, left: float, instead: bool
) -> None:
    later = dataclasses.replace(candidate("nonlinearity", 3000.0), absorbed=absorbed)
    assert instead_of_it(later, WITHOUT, seen(left, 0.0)) is instead


@pytest.mark.parametrize(
    ("gap", "left", "nothing"),
    [(2.0, 0.05, True), (2.0, 0.2, False), (-0.03, -0.08, False), (0.05, 0.0, False)],
)
def test_near_the_floor_a_search_is_not_ended_by_the_total(
    gap: float, left: float, nothing: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Less than a twentieth is left, of a gap of which a part means something, and no family speaks
    against the effects: by being as it was, by being worse than it was, or by what is left of it.
    """
    before, after = seen(gap, 5.0), seen(left, 0.0)
    assert closing.nothing_left(before, after) is nothing
    for family in ("untouched", "spoilt", "lingering"):
        with monkeypatch.context() as with_it:
            with_it.setattr(closing, family, lambda *distances, **worth: ("rows",))
            assert not closing.nothing_left(before, after)


@pytest.mark.parametrize(
    ("gap", "left", "ends", "on"),
    [
        (2.0, 1.4, False, True),
        (2.0, 1.6, False, False),  # a fifth of a gap
        (2.0, 1.6, True, True),  # but by its own errors no more than chance makes
        (0.2, 0.19, False, True),  # nor does a part of a small gap say anything
    ],
)
def test_a_search_goes_on_beside_an_effect_that_closes_a_quarter(
    gap: float, left: float, ends: bool, on: bool
) -> None:
    base, first = seen(gap, 0.0), SimpleNamespace(left=seen(left, 0.0), ends=ends)
    base.floor = 0.0
    assert leads(cast(Any, first), base) is on


def test_what_lingers_is_told() -> None:
    """More than a tenth of the gap of the family that was most off, or much in itself and a 33rd of
    what it was, and beyond doubt; or a third of it, where that was little. A third of any other
    one, if that is beyond doubt and much in itself.
    """

    def far(codes: float, rows: float, chance: float) -> Distance:
        return Distance(
            total=1.0,
            by_family={"codes": codes, "rows": rows},
            p_by_family={"codes": chance, "rows": 0.0 if rows > 1.0 else 0.3},
            p_value=0.0,
        )

    before = far(256.0, 30.0, 0.0)
    assert lingering(before, far(29.0, 8.9, 1e-90)) == ("codes",)
    assert lingering(before, far(7.6, 8.9, 1e-90)) == ()
    assert lingering(before, far(10.0, 8.9, 1e-90)) == ("codes",)
    assert lingering(before, far(29.0, 8.9, 1e-9)) == ()
    assert lingering(before, far(2.0, 9.1, 1e-90)) == ("rows",)
    assert lingering(far(256.0, 5.0, 0.0), far(2.0, 2.9, 1e-90)) == ()
    assert lingering(far(256.0, 1.0, 0.0), far(2.0, 15.1, 1e-90)) == ()
    little = far(3.8, 0.5, 1e-20)
    assert lingering(little, far(2.8, 0.4, 1e-13)) == ("codes",)
    assert lingering(little, far(1.2, 0.4, 1e-13)) == ("codes",)
    assert lingering(little, far(1.1, 0.4, 1e-13)) == ()
    assert lingering(little, far(2.8, 0.4, 1e-5)) == ()
    few_figures = far(32.0, 30.0, 1e-3)
    assert lingering(few_figures, far(32.0, 2.9, 1e-3)) == ()
    assert lingering(few_figures, far(0.0, 11.0, 1.0)) == ("rows",)


def test_what_whole_codes_tell_stands_whatever_else_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A family as it was speaks against a fitted effect, and not against bits that are empty."""
    monkeypatch.setattr(trail, "untouched", lambda before, after: ("tails",))
    lost, left = catalogue()["bit_truncation"](), catalogue()["vibration"]()

    def of(*effects: Any) -> Any:
        return SimpleNamespace(models=[SimpleNamespace(effects=effects)], measured=[None, None])

    assert trail.still_untouched(of(left), {"bit_truncation"})
    assert trail.still_untouched(of(lost), set())
    assert not trail.still_untouched(of(lost), {"bit_truncation"})


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


@pytest.mark.parametrize(
    ("total", "error", "wide"), [(-0.4, 0.05, True), (-0.2, 0.05, False), (-0.4, 0.5, False)]
)
def test_a_model_is_too_wide_where_its_own_bodies_would_show_more(
    total: float, error: float, wide: bool
) -> None:
    left: Any = SimpleNamespace(held=SimpleNamespace(total=total), held_error=error)
    assert too_wide(left) is wide
