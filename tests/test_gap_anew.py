"""Where a suspect's calibration begins, and where it goes on if no small step leads there."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from analysis.gap.look.arithmetic import IN_FRACTIONS, OF_QUARTERS, OF_WHOLE_SAMPLES
from analysis.gap.measure.signature import starts
from analysis.gap.ready.hints import DirectReading
from analysis.gap.suspects import anew, beginnings, starting_points, valley
from analysis.gap.suspects.beginnings import LOUDER, as_dark, choices, every_choice
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.chroma_subsampling import ChromaSubsampling
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.demosaic_other import DemosaicOther
from sensor.effects.dropped_frames import DroppedFrames
from sensor.effects.gamma import Gamma
from sensor.effects.jpeg import Jpeg
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.sharpening import Sharpening
from tests.candidates import BASE


def rugged(effect: ColorMatrix) -> float:
    """A deviance that has waves all along and a valley of a tenth of the way at 1.04."""
    off = (effect.saturation - 1.04) / 0.04
    return float(-100.0 * np.exp(-0.5 * (off / 0.1) ** 2) + np.cos(40.0 * off))


@pytest.mark.parametrize("begun", [1.03, 1.055, 1.07])
def test_a_strength_that_no_small_step_leads_to(
    begun: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From 0.6 to 1.75 times the strength some factor comes to within a tenth of the valley, and
    smaller changes from there to within a fiftieth."""

    def against(base: Any, seen: Any, scenery: Any, effects: Any) -> Any:
        return SimpleNamespace(base=base, effects=effects, deviance=rugged(effects[-1]))

    def begins(saturation: float) -> Any:
        return against(None, None, None, (Gamma(), ColorMatrix(saturation=saturation)))

    monkeypatch.setattr(valley, "refined", against)
    here, nothing = begins(begun), cast(Any, None)
    found = valley.another_valley(here, nothing, nothing)
    assert found is not None
    assert found.effects[0] == Gamma()
    assert cast(ColorMatrix, found.effects[-1]).saturation == pytest.approx(1.04, abs=0.02 * 0.04)
    assert found.deviance < here.deviance - 50.0
    assert valley.another_valley(begins(1.04), nothing, nothing) is None


def test_all_choices_of_an_effect_are_made_with_its_strength_as_it_is() -> None:
    chosen = every_choice(Sharpening(amount=0.1, passes=2))
    assert len(chosen) == len(set(chosen)) == 4
    assert {(c.amount, c.passes, c.each_colour) for c in chosen} == {
        (0.1, p, e) for p in (1.0, 2.0) for e in (0.0, 1.0)
    }
    told = every_choice(ChromaSubsampling(mode=1, drawn=1), {"mode": 1.0, "drawn": 1.0})
    assert {(c.mode, c.drawn) for c in told} == {(1.0, 1.0)}
    assert {(c.whole_codes, c.of_whole_codes, c.taken) for c in told} == {
        (w, o, t) for w in (0.0, 1.0, 2.0, 3.0) for o in (0.0, 1.0) for t in (0.0, 1.0, 2.0)
    }
    assert every_choice(DroppedFrames(probability=0.3)) == [DroppedFrames(probability=0.3)]


def test_every_way_to_fill_in_colours_is_another_choice() -> None:
    """A choice without beginnings of its own is made in all ways that do something."""
    others = choices(DemosaicOther(algorithm=2.0))
    assert others == [DemosaicOther(algorithm=a) for a in (1.0, 3.0, 4.0, 5.0)]


def test_darks_begin_as_bright_as_they_are_and_as_loud_as_what_gathers_in_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Codes cut to multiples of four are (0 + 1 + 2 + 3) / 4 = 1.5 DN darker: so much is missing
    from the black of a camera whose twins are cut once more. Lit shots say nothing of it."""
    colours = np.array([3.0, 2.0, 4.0])
    dark = np.broadcast_to(colours[:, None], (5, 2, 3, 7)).copy()
    lit = dark + 100.0
    shown = np.concatenate([dark, lit], axis=1)
    cut = np.concatenate([dark - 1.5, lit - 7.0], axis=1)
    bodies = SimpleNamespace(shots=("a", "b", "c", "d"), means=cut)
    monkeypatch.setattr(beginnings, "together", lambda several: bodies)
    base = dataclasses.replace(BASE, black_dn=np.ones(3), dark_e_per_s=9e5, shown_e_per_s=4500.0)
    found = cast(Any, SimpleNamespace(base=base, bodies={}, lit=frozenset({"c", "d"})))
    begun = as_dark(found, cast(Any, SimpleNamespace(means=shown)))
    np.testing.assert_allclose(begun.black_dn, 2.5)
    assert begun.dark_e_per_s == 4500.0
    darker = dataclasses.replace(base, shown_e_per_s=-20.0)
    found = cast(Any, SimpleNamespace(base=darker, bodies={}, lit=found.lit))
    assert as_dark(found, cast(Any, SimpleNamespace(means=shown))).dark_e_per_s == 0.0


def test_where_frames_tell_a_camera_the_light_is_not_that_of_another_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A signature changes the light for an effect beside the camera that is known. The camera that
    frames tell with the effect begins under the light as it was."""
    lights = []

    def refine(base: Any, seen: Any, scenery: Any, effects: Any, **how: Any) -> Any:
        lights.append(scenery.light)
        return SimpleNamespace(base=base, effects=effects, misfit=0.8, deviance=-1.0)

    def refined(base: Any, seen: Any, scenery: Any, effects: Any) -> Any:
        return SimpleNamespace(base=base, effects=effects, misfit=3.0, deviance=0.0)

    monkeypatch.setattr(anew, "refine", refine)
    monkeypatch.setattr(anew, "refined", refined)
    monkeypatch.setattr(starting_points, "refined", refined)
    monkeypatch.setattr(starting_points, "counted", lambda found, seen, scenery: found)
    monkeypatch.setattr(anew, "_scored", lambda case, found, base, effect: found)
    ambient = AmbientLight(rate_e_per_s=2e5)
    as_it_was = SimpleNamespace(light="as it was", rules=())
    known = SimpleNamespace(scenery=as_it_was, effects=(), base=BASE)
    case: Any = SimpleNamespace(known=known, misfit=3.0, fit_seen=None)
    found: Any = SimpleNamespace(
        base=BASE,
        effect=ambient,
        name=ambient.name,
        scenery=SimpleNamespace(light="changed", rules=()),
        misfit=3.0,
    )
    anew.anew(case, found, ambient, DirectReading(hints={}, exact=False, base=BASE))
    anew.anew(case, found, ambient, DirectReading(hints={}, exact=False))
    assert lights == ["as it was", "changed"]


@pytest.mark.parametrize("exact", [True, False])
def test_a_codec_is_calibrated_as_it_most_likely_was(
    exact: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frames tell the quality, not how colours were stored: that is tried with the noise and the
    edges which the codec took away, and with darks as bright as they are; and what the likeliest
    leads to begins with each way of counting."""
    begun = []

    def refine(base: Any, seen: Any, scenery: Any, effects: Any, **how: Any) -> Any:
        begun.append((base.blur_px2, base.arithmetic, effects[-1].subsampling))
        off = -1.0 if base.blur_px2 == 0 else 0.0
        return SimpleNamespace(base=base, effects=effects, misfit=3.0, deviance=off)

    def refined(base: Any, seen: Any, scenery: Any, effects: Any) -> Any:
        sharp = base.blur_px2 == 0 and base.read_dn2[0] > 1
        right = sharp and effects[-1].subsampling == 2
        off = 5.0 if right else 6.5
        chi2 = off + base.arithmetic  # each way of counting looks like none other
        return SimpleNamespace(base=base, effects=effects, misfit=off, deviance=off, chi2=chi2)

    monkeypatch.setattr(anew, "refine", refine)
    monkeypatch.setattr(anew, "refined", refined)
    monkeypatch.setattr(starting_points, "refined", refined)
    monkeypatch.setattr(starting_points, "as_dark", lambda found, seen: found.base)
    monkeypatch.setattr(starting_points, "counted", lambda found, seen, scenery: found)
    monkeypatch.setattr(anew, "_scored", lambda case, found, base, effect: found)
    soft = dataclasses.replace(BASE, blur_px2=0.2)
    rules = (IN_FRACTIONS, OF_WHOLE_SAMPLES, OF_QUARTERS)
    scenery: Any = SimpleNamespace(light="as it was", rules=rules)
    case: Any = SimpleNamespace(
        known=SimpleNamespace(scenery=scenery, effects=(), base=soft), misfit=9.0, fit_seen=None
    )
    jpeg = Jpeg(quality=90.0, subsampling=1.0)
    found: Any = SimpleNamespace(base=soft, effect=jpeg, name="jpeg", scenery=scenery, misfit=6.0)
    anew.anew(case, found, jpeg, DirectReading(hints={"quality": 90.0}, exact=exact))
    assert (soft.blur_px2, IN_FRACTIONS, 2.0) in begun[:2]
    led = [one for one in begun if one[0] == 0.0]
    assert led[:3] == [(0.0, rule, 2.0) for rule in rules]


@pytest.mark.parametrize(("next_best", "tried"), [(5.9, [2.0, 0.0]), (6.1, [2.0])])
def test_choices_that_are_about_as_likely_before_calibration_are_calibrated_as_well(
    next_best: float, tried: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Up to a fifth more than the likeliest leaves, which goes first; each with what a codec takes
    away given back, and with darks as bright as they are."""
    leaves = {0.0: next_best, 1.0: 9.0, 2.0: 5.0}

    def refined(base: Any, seen: Any, scenery: Any, effects: Any) -> Any:
        return SimpleNamespace(base=base, effects=effects, misfit=leaves[effects[-1].subsampling])

    monkeypatch.setattr(starting_points, "refined", refined)
    monkeypatch.setattr(starting_points, "as_dark", lambda found, seen: found.base)
    known = SimpleNamespace(effects=(), base=BASE)
    jpeg = Jpeg(quality=90.0, subsampling=1.0)
    every: Any = starting_points.StartingPoints(
        case=cast(Any, SimpleNamespace(known=known, fit_seen=None)),
        scenery=cast(Any, None),
        as_found=cast(Any, None),
        base=BASE,
        effect=jpeg,
        told=DirectReading(hints={"quality": 90.0}, exact=False),
        tuned=True,
    )
    gone = [effect.subsampling for _, effect in every.of_what_is_hidden(every.as_found)]
    assert gone == [one for one in tried for _ in range(2)]


@pytest.mark.parametrize(("as_it_is", "times"), [(1.0, 1.0), (9.0, LOUDER)])
def test_a_quiet_camera_is_as_quiet_behind_a_cable(
    as_it_is: float, times: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a choice that leaves 5.0 with twice the noise, and less or more as the camera was
    calibrated: the likelier of both is where the search begins."""

    def refined(base: Any, seen: Any, scenery: Any, effects: Any) -> Any:
        misfit = as_it_is if np.array_equal(base.read_dn2, BASE.read_dn2) else 5.0
        return SimpleNamespace(base=base, effects=effects, misfit=misfit)

    monkeypatch.setattr(starting_points, "refined", refined)
    known = SimpleNamespace(effects=(), base=BASE)
    every: Any = starting_points.StartingPoints(
        case=cast(Any, SimpleNamespace(known=known, fit_seen=None)),
        scenery=cast(Any, None),
        as_found=cast(Any, None),
        base=BASE,
        effect=Jpeg(quality=90.0, subsampling=1.0),
        told=DirectReading(hints={"quality": 90.0}, exact=False),
        tuned=True,
    )
    for begun in every._unhidden:
        assert begun.base.read_dn2 == pytest.approx(times * BASE.read_dn2)
    assert len(every._unhidden) == 3


def test_other_choices_are_made_beside_the_likeliest_camera_so_far(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two passes of a sharpening show themselves in whole samples, and three had been likelier in
    fractions: beside those two left as much as three."""
    monkeypatch.setattr(starting_points, "refined", lambda base, *rest: SimpleNamespace(base=base))
    monkeypatch.setattr(starting_points, "counted", lambda found, seen, scenery: found)
    begun = Sharpening(amount=0.21, passes=3)
    better = Sharpening(amount=0.30, passes=3)
    counts = dataclasses.replace(BASE, arithmetic=OF_WHOLE_SAMPLES)
    best: Any = (None, SimpleNamespace(base=counts, effects=(better,), misfit=1.5))
    known = SimpleNamespace(effects=(), base=BASE)
    every: Any = starting_points.StartingPoints(
        case=cast(Any, SimpleNamespace(known=known, fit_seen=None)),
        scenery=cast(Any, SimpleNamespace(rules=(IN_FRACTIONS, OF_WHOLE_SAMPLES))),
        as_found=cast(Any, (None, SimpleNamespace(base=BASE, effects=(begun,), misfit=3.5))),
        base=BASE,
        effect=begun,
        told=None,
        tuned=True,
    )
    for so_far, rule, amount in (
        (best, OF_WHOLE_SAMPLES, 0.30),
        (every.as_found, IN_FRACTIONS, 0.21),
    ):
        made = list(every.by_choosing(so_far))
        assert {base.arithmetic for base, _ in made} == {rule}
        assert {effect.amount for _, effect in made} == {amount}
        assert 2.0 in {effect.passes for _, effect in made}
    for exact, others in ((True, set()), (False, {2.0, 4.0})):
        told = DirectReading(hints={"passes": 3.0}, exact=exact)
        made = list(dataclasses.replace(every, told=told).by_choosing(best))
        assert {effect.passes for _, effect in made} - {3.0} >= others
        assert ({effect.passes for _, effect in made} <= {3.0}) is exact


@pytest.mark.parametrize(
    ("effect", "misfit", "left", "tried"),
    [
        (AmbientLight(rate_e_per_s=2e5), 1.9, 1.2, []),  # light hides nothing of how codes are made
        (AmbientLight(rate_e_per_s=2e5), 9.0, 5.0, [OF_WHOLE_SAMPLES, OF_QUARTERS]),
        (AmbientLight(rate_e_per_s=2e5), 9.0, 5.6, []),  # far from the camera, and going nowhere
        (Sharpening(amount=0.3), 1.9, 1.9, [OF_WHOLE_SAMPLES, OF_QUARTERS]),
    ],
)
def test_ways_of_counting_are_tried_where_they_cannot_be_seen(
    effect: Any, misfit: float, left: float, tried: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a suspect that left 6.0 as it was found; none is tried that looks like another one to the
    last digit."""

    def against(base: Any, *rest: Any) -> Any:
        return SimpleNamespace(base=base, chi2=base.arithmetic if told_apart else 1.0)

    monkeypatch.setattr(starting_points, "refined", against)
    monkeypatch.setattr(starting_points, "counted", lambda found, seen, scenery: found)
    rules = (IN_FRACTIONS, OF_WHOLE_SAMPLES, OF_QUARTERS)
    known = SimpleNamespace(effects=(), base=BASE)
    found = SimpleNamespace(base=BASE, effect=effect)
    every: Any = starting_points.StartingPoints(
        case=cast(Any, SimpleNamespace(known=known, fit_seen=None, misfit=misfit)),
        scenery=cast(Any, SimpleNamespace(rules=rules)),
        as_found=cast(Any, (found, SimpleNamespace(base=BASE, misfit=6.0))),
        base=BASE,
        effect=effect,
        told=None,
        tuned=True,
    )
    best: Any = (found, SimpleNamespace(base=BASE, misfit=left))
    for told_apart in (True, False):
        made = [base.arithmetic for base, _ in every.by_every_rule(best)]
        assert made == (tried if told_apart else [])


def test_a_lamp_is_looked_for_that_dims_and_one_that_warms() -> None:
    """Wander has no sign and trend has: with the wrong one no amount has both."""
    changes = [effect.change for effect in starts(LampDrift)]
    assert min(changes) < 0 < max(changes)


@pytest.mark.parametrize("gained", [10.0, -10.0])
def test_a_strength_that_is_off_is_added_where_that_is_likelier(
    gained: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the cost of both: what the frames say, and what parameters cost."""

    def tried(effect: Any) -> Any:
        return SimpleNamespace(effect=effect), SimpleNamespace(base=BASE, effects=(effect,))

    def cost(case: Any, found: Any) -> float:
        return -gained if found.effect.frame_sigma_e > 0 else 0.0

    monkeypatch.setattr(anew, "cost", cost)
    found = tried(BlackLevelDrift(row_sigma_e=5.0, frame_sigma_e=0.0))
    best = anew.with_all_strengths(cast(Any, None), found, lambda base, effect: tried(effect))
    assert (best[0].effect.frame_sigma_e > 0) is (gained > 0)
    assert best[0].effect.row_sigma_e == 5.0
