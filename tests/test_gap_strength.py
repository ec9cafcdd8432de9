"""Fitted parameters as they are reported, and their errors."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.camera.handles import Handle, free_parameters
from analysis.gap.measure.distance import Distance
from analysis.gap.report import Figure
from analysis.gap.verdict import strength as strength_of
from analysis.gap.verdict.strength import OF_A_SEARCH
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.blooming import Blooming
from sensor.effects.lamp_displacement import LampDisplacement
from tests.candidates import candidate


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


@pytest.mark.parametrize(("by", "expected"), [(500.0, 17_500.0), (-8500.0, 17_000.0)])
def test_a_last_step_does_not_lead_far_from_a_threshold(by: float, expected: float) -> None:
    """Half of a full well shows another picture, and not twice the first."""
    full_well = next(p for p in catalogue()["blooming"].parameters() if p.name == "full_well_e")
    assert strength_of.last_step(full_well, 17_000.0, by) == expected


def test_errors_of_a_model_that_does_not_fit_are_as_much_larger() -> None:
    """A family of 8 times the chi-squared that is expected makes errors sqrt(8) times as large, if
    chance does not; the one with the largest share need not be the one that is beyond it."""

    def left(p_value: float) -> Distance:
        by_family = {"codes": 7.0, "level": 11.0, "rows": 0.1}
        chances = {"codes": 1e-12, "level": 0.03, "rows": 0.4}
        return Distance(total=0.2, by_family=by_family, p_by_family=chances, p_value=p_value)

    assert strength_of.birge_ratio(left(1e-10)) == pytest.approx(np.sqrt(8.0))
    assert strength_of.birge_ratio(left(0.2)) == 1.0


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
    assert error / (value * np.log(2)) == pytest.approx(octaves / z)


def fitted(effect: Effect, parameter: str, by: float, error: float, told: Any = None) -> Figure:
    """A parameter as it is reported whose last step is this long."""
    handle = Handle(effect=effect.name, parameter=parameter)
    model: Any = SimpleNamespace(ways=SimpleNamespace(knobs=(), tuned=(handle,)))
    whole = Distance(total=0.0, by_family={}, p_by_family={}, p_value=0.5)
    after: Any = SimpleNamespace(amounts=np.array([by]), errors=np.array([error]), whole=whole)
    found = dataclasses.replace(candidate(effect.name, 1e4), told=told)
    (p,) = (p for p in free_parameters(effect) if p.name == parameter)
    return strength_of.figure_of(effect, p, model, after, found)


def test_a_step_that_is_not_made_says_nothing_of_a_threshold() -> None:
    """It is known to a quarter then."""
    figure = fitted(Blooming(full_well_e=17_000.0), "full_well_e", -8500.0, 500.0)
    assert figure.value == 17_000.0
    assert figure.se == pytest.approx(OF_A_SEARCH * np.hypot(500.0, 17_000.0 / 4))


@pytest.mark.parametrize(
    ("told", "value", "error"),
    [
        (None, 11.0, np.hypot(0.5, 1.0)),
        ({}, 10.0, 0.5),
        ({"right_cm": 2.0}, 10.0, 2.0),
        ({"right_cm": 0.2}, 10.0, 0.5),
    ],
    ids=["fitted", "told", "told by few", "told by many"],
)
def test_what_frames_tell_is_not_moved(
    told: Mapping[str, float] | None, value: float, error: float
) -> None:
    """A last step of 1 +- 0.5 is made by a fit alone, which knows it to as much as it is long, and
    no error is less than the fit's."""
    figure = fitted(LampDisplacement(right_cm=10.0), "right_cm", 1.0, 0.5, told)
    assert figure.value == pytest.approx(value)
    assert figure.se == pytest.approx(OF_A_SEARCH * error)


def test_where_the_lamp_stood_is_stated_and_not_looked_for() -> None:
    """Nor is how wide the picture is: their handles would bend the slope that the lamp makes."""
    assert [p.name for p in free_parameters(LampDisplacement(up_cm=2.0))] == ["right_cm", "up_cm"]


@pytest.mark.parametrize(
    ("leakage", "colour"),
    [
        (Colours(R=0.0036, G=0.0, B=0.0), "R"),
        (Colours(R=0.0, G=0.0002, B=-0.0036), "B"),
        (Colours(R=0.0041, G=0.0036, B=0.0038), "G"),
        (Colours(R=0.0, G=0.0, B=0.0), "G"),
    ],
)
def test_a_strength_is_that_of_green_where_green_has_the_effect(
    leakage: Colours, colour: str
) -> None:
    (parameter,) = (
        p for p in catalogue()["spectral_response_error"].parameters() if p.name == "leakage"
    )
    assert strength_of.reported_colour(leakage, parameter) == colour
