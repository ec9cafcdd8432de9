"""Fitted parameters as they are reported, and their errors."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.measure.distance import Distance
from analysis.gap.verdict import strength as strength_of
from sensor.catalogue import catalogue


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
    assert np.log2((value + error) / value) == pytest.approx(octaves / (2 * z), rel=0.05)
