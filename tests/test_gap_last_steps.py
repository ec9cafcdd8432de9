"""The last steps of a calibration, by all that is known around a camera.

Steps go on until one is short beside what is known of a parameter. With x the parameter, s its
standard error and a the next step,

    |a| <= s / 2,    and |x + a - truth| / s is what chance makes: beyond 3.3 once in a thousand.
"""

from __future__ import annotations

import functools
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.calibrate.fit import around
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import Setting, look
from analysis.gap.search import last_steps
from analysis.gap.search.last_steps import LONG, at_its_end
from analysis.gap.search.step import Step
from analysis.identifiability.known import base_of
from sensor.effects.gamma import Gamma
from sensor.record import record
from tests.candidates import candidate
from tests.short import PROTOCOL, camera, light

LAMP = "lamp"
TRUTH = 0.95
ONCE_IN_A_THOUSAND = 3.3


@functools.cache
def setting() -> Setting:
    bent = camera().plus(Gamma(exponent=TRUTH))
    found = look(record(bent, PROTOCOL, {LAMP: light().rate_e_per_s}), {LAMP: light()})
    assert found is not None
    return found


@functools.cache
def step_with(exponent: float) -> Step:
    """By which so strong a gamma was added to the camera as it is."""
    model = around(base_of(camera(), [LAMP]), setting().scenery, [Gamma(exponent=exponent)])
    choice: Any = SimpleNamespace(best=candidate("gamma", 500.0))
    return Step(choice=choice, model=model, left=measured(model, setting().seen), ends=True)


def gamma_of(step: Step) -> tuple[float, float, float]:
    """The exponent, the next step of it, and its standard error."""
    place = len(step.model.ways.knobs)
    (effect,) = step.model.effects
    assert isinstance(effect, Gamma)
    return effect.exponent, float(step.left.amounts[place]), float(step.left.errors[place])


@pytest.mark.whole
def test_steps_go_on_until_they_are_short() -> None:
    begun = step_with(0.965)
    _, first, error = gamma_of(begun)
    assert abs(first) > 5 * error
    exponent, last, error = gamma_of(at_its_end(setting(), begun, {"gamma"}))
    assert abs(last) < LONG * error
    assert abs(exponent + last - TRUTH) < ONCE_IN_A_THOUSAND * error


def test_where_the_last_step_is_short_no_other_is_made() -> None:
    there = at_its_end(setting(), step_with(0.965), {"gamma"})
    assert at_its_end(setting(), there, {"gamma"}) is there


def test_what_frames_tell_is_not_moved() -> None:
    begun = step_with(0.965)
    assert at_its_end(setting(), begun, set()) is begun


def test_a_step_that_leads_away_is_not_made() -> None:
    """Amounts that point the other way, as directions would that are not those of this place."""
    begun = step_with(0.97)
    wrong = SimpleNamespace(**{**vars(begun.left), "amounts": -3.0 * begun.left.amounts})
    wrong.held_error = begun.left.held_error
    astray: Any = SimpleNamespace(choice=begun.choice, model=begun.model, left=wrong, ends=True)
    assert np.abs(wrong.amounts).max() > 0
    assert at_its_end(setting(), astray, {"gamma"}) is astray


def test_a_step_that_leaves_something_where_nothing_was_left_is_not_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever it leaves in total: one family may be off where all others are nearer."""
    begun = step_with(0.965)
    for ends in (False, True):
        further: Any = SimpleNamespace(
            choice=begun.choice,
            model=begun.model,
            left=SimpleNamespace(
                whole=SimpleNamespace(total=begun.left.whole.total - 1.0),
                amounts=np.zeros_like(begun.left.amounts),
                errors=begun.left.errors,
            ),
            ends=ends,
        )
        monkeypatch.setattr(last_steps, "_further", lambda *_, step=further: step)
        assert (at_its_end(setting(), begun, {"gamma"}) is further) is ends
