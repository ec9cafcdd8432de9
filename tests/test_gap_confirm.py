"""A suspect as it was found, and the camera with it.

Light that a search has changed for a suspect is as wrong as the camera beside which it was
changed. Frames show it: with light that falls off from +d to -d across the picture, and a camera
that is right otherwise, a step of calibration leaves less than a tenth of d.
"""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.calibrate.fit import around
from analysis.gap.calibrate.nuisance import knobs_of
from analysis.gap.calibrate.refine import Refined
from analysis.gap.camera.twin import Scenery
from analysis.gap.ready.setting import look
from analysis.gap.search import confirm
from analysis.gap.search.choice import Choice
from analysis.identifiability.known import base_of
from sensor.effects.adc_dnl import AdcDnl
from sensor.effects.dust_shadow import DustShadow
from sensor.effects.sharpening import Sharpening
from sensor.record import record
from tests.candidates import candidate
from tests.short import PROTOCOL, camera, light

LAMP = "lamp"
FALL = 0.05


def shaded(scenery: Scenery) -> Scenery:
    """Under light that falls off from left to right."""
    rates = scenery.light.rates[LAMP]
    fall = 1.0 + FALL * np.linspace(1.0, -1.0, rates.shape[1])
    shown = {LAMP: rates * fall[None, :, None]}
    return dataclasses.replace(scenery, light=dataclasses.replace(scenery.light, shown=shown))


def fall_of(scenery: Scenery) -> float:
    """Half of how much brighter the left half is than the right one, of what the truth would be."""
    ratio = scenery.light.falls[LAMP] / light().rate_e_per_s
    left, right = (half.mean() for half in np.array_split(np.asarray(ratio), 2, axis=1))
    return float((left - right) / (left + right))


@pytest.mark.whole
def test_processing_is_counted_anew_under_light_as_the_frames_show_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sharp = Sharpening(amount=0.8)
    setting = look(
        record(camera().plus(sharp), PROTOCOL, {LAMP: light().rate_e_per_s}), {LAMP: light()}
    )
    assert setting is not None
    known = around(base_of(camera(), [LAMP]), setting.scenery)
    begun = shaded(setting.scenery)
    assert abs(fall_of(begun)) == pytest.approx(FALL / 2, rel=0.05)
    found = dataclasses.replace(
        candidate("sharpening", 500.0),
        effect=Sharpening(amount=0.1),
        base=known.base,
        scenery=begun,
    )
    heard: list[Scenery] = []

    def as_it_is(now: Refined, seen: Any, scenery: Scenery) -> Refined:
        heard.append(scenery)
        return now

    monkeypatch.setattr(confirm, "recounted", as_it_is)
    choice = Choice(best=found, probability=0.9, alike=(), by_name={})
    assert not confirm._as_found(setting, known, choice).ends
    (scenery,) = heard
    assert abs(fall_of(scenery)) < FALL / 20


def test_no_step_is_taken_to_a_camera_in_which_nothing_of_its_effect_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """However little it leaves: dust without depth is no dust."""
    monkeypatch.setattr(confirm, "nearer", lambda one, other: other)

    def step(effect: DustShadow) -> Any:
        return SimpleNamespace(model=SimpleNamespace(effects=(effect,)))

    found, calibrated, gone = map(step, (DustShadow(), DustShadow(depth=0.01), DustShadow(depth=0)))
    assert confirm._nearer_with_it(found, calibrated) is calibrated
    assert confirm._nearer_with_it(found, gone) is found


def test_a_spread_of_dark_current_that_was_lost_begins_anew() -> None:
    """From no spread no step leads back, as what it moves it moves by a part of itself; some of the
    fixed offsets are it as well. Darks of one exposure cannot tell one from the other."""
    setting = look(record(camera(), PROTOCOL, {LAMP: light().rate_e_per_s}), {LAMP: light()})
    assert setting is not None
    known = around(base_of(camera(), [LAMP]), setting.scenery)

    def begun(spread2: float, scenery: Scenery) -> list[float]:
        base = dataclasses.replace(known.base, dark_spread2=spread2)
        found: Any = SimpleNamespace(model=SimpleNamespace(base=base, scenery=scenery))
        return [one.dark_spread2 for one in confirm._beginnings(found, known)]

    one = setting.scenery
    (dark,) = (shot for shot in one.shots if shot.dark)
    longer = dataclasses.replace(dark, exposure_s=4 * dark.exposure_s)
    two = dataclasses.replace(one, shots=(*one.shots, longer))
    first = known.base.dark_spread2
    assert begun(9.0, two) == [9.0, first]
    assert begun(0.0, one) == [0.0, first]
    *before, anew = begun(0.0, two)
    assert before == [0.0, first]
    assert anew > 0


@pytest.mark.parametrize("told", [None, {"depth": 0.01}])
@pytest.mark.parametrize(
    ("ends", "begun", "others"),
    [((), ["led astray", "before", "smooth"], 1), (("before",), ["led astray", "before"], 0),
     (("led astray",), ["led astray"], 0)],
)  # fmt: skip
def test_what_leaves_something_is_calibrated_from_the_camera_before_it_as_well(
    ends: tuple[str, ...],
    begun: list[str],
    others: int,
    told: Any,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A flicker noise ended beside a fixed pattern that its pursuit had made too small, and from
    the camera without it to one that leaves a third. What is wrong at edges hides what light is
    like within pixels. Of what frames tell no other choice is made.
    """
    seen: list[str] = []
    chosen: list[str] = []

    monkeypatch.setattr(confirm, "lost_its_spread", lambda base, scenery: False)
    monkeypatch.setattr(confirm, "under_other_light", lambda base, light: ["smooth"])

    def step(base: str) -> Any:
        left = SimpleNamespace(held=SimpleNamespace(total=0.1))
        scenery = SimpleNamespace(light=None)
        model = SimpleNamespace(base=base, effects=(DustShadow(),), scenery=scenery)
        return SimpleNamespace(ends=base in ends and bool(seen), left=left, model=model)

    def calibrated(setting: Any, found: Any, effects: Any, base: str) -> Any:
        seen.append(base)
        return step(base)

    monkeypatch.setattr(confirm, "_as_found", lambda setting, model, choice: step("led astray"))
    monkeypatch.setattr(confirm, "_calibrated", calibrated)
    monkeypatch.setattr(confirm, "nearer", lambda one, other: other)
    monkeypatch.setattr(
        confirm, "_with_other_choices", lambda setting, now: chosen.append(now.model.base) or now
    )
    found: Any = SimpleNamespace(name="dust_shadow", model=None, misfit=9.0, told=told)
    now: Any = SimpleNamespace(held=SimpleNamespace(total=1.0))
    model: Any = SimpleNamespace(base="before")
    choice: Any = SimpleNamespace(best=found)
    confirm.with_it(SimpleNamespace(), model, now, choice, lambda what: None)  # type: ignore[arg-type]
    assert seen == begun
    assert len(chosen) == (others if told is None else 0)


@pytest.mark.whole
@pytest.mark.parametrize("in_electrons", [True, False])
def test_a_blur_is_calibrated_where_light_comes_from_outside_of_the_frames(
    in_electrons: bool,
) -> None:
    """A surface through the frames is as smooth as any blur would make it."""
    capture = record(camera(), PROTOCOL, {LAMP: light().rate_e_per_s})
    setting = look(capture, {LAMP: light()})
    assert setting is not None
    lit = dataclasses.replace(setting.scenery.light, in_electrons=in_electrons)
    knobs = knobs_of(base_of(camera(), [LAMP]), dataclasses.replace(setting.scenery, light=lit))
    assert any(knob.name == "blur" for knob in knobs) == in_electrons


def test_what_leaves_something_is_tried_with_its_other_strength(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A converter that compares leaves something, and one that weighs nothing."""

    def step(effect: AdcDnl) -> Any:
        weighs = effect.unit_mismatch > 0
        left = SimpleNamespace(
            held=SimpleNamespace(total=0.0 if weighs else 5.0),
            whole=SimpleNamespace(p_by_family={"codes": 0.5 if weighs else 1e-9}),
        )
        model = SimpleNamespace(effects=(effect,), base="base")
        return SimpleNamespace(model=model, left=left, ends=weighs)

    tried: list[AdcDnl] = []

    def calibrated(setting: Any, now: Any, effects: Any, base: Any) -> Any:
        tried.append(effects[-1])
        return step(effects[-1])

    monkeypatch.setattr(confirm, "_calibrated", calibrated)
    nothing: Any = None
    compares = AdcDnl(unit_mismatch=0.0, threshold_sigma_dn=0.1)
    best = confirm._with_other_choices(nothing, step(compares))
    (other,) = tried
    assert best.ends
    assert best.model.effects == (other,)
    assert other.unit_mismatch > 0
    assert other.threshold_sigma_dn == 0
