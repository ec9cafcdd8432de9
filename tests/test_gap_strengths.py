"""Parameters of effects: how strong one is, how far a step goes, what is sought together."""

from __future__ import annotations

import dataclasses

import pytest

from analysis.gap.camera.handles import (
    Handle,
    does_nothing,
    free_parameters,
    handles_of,
    moved,
    step_from,
)
from analysis.gap.measure.signature import scaled, starts
from analysis.gap.suspects.beginnings import of_other_strengths, with_more_strengths
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.defect_correction import DefectCorrection
from sensor.effects.dust_shadow import DustShadow
from sensor.effects.gamma import Gamma
from sensor.effects.spectral_response_error import SpectralResponseError
from sensor.effects.specular_glare import SpecularGlare
from sensor.effects.vignetting_excess import VignettingExcess


def test_a_threshold_is_twice_as_strong_at_half_its_value() -> None:
    """Its identity is ten thousand times away, and no threshold at all is none; a step of the
    difference quotient is a part of the threshold itself."""
    threshold = next(p for p in DefectCorrection.parameters() if p.identity is not None)
    assert threshold.inverse
    assert threshold.away(6.0, 2.0) == pytest.approx(3.0)
    assert threshold.away(6.0, 1.0) == pytest.approx(6.0)
    assert threshold.away(6.0, 0.0) == threshold.away(6.0, 1e-9) == threshold.maximum
    assert abs(step_from(6.0, threshold)) == pytest.approx(0.6)
    share = next(p for p in SpecularGlare.parameters() if p.identity is not None)
    assert not share.inverse


def test_a_step_of_a_parameter_stays_in_its_range() -> None:
    for across in (0.0, 0.02, 0.5, 0.98, 1.0):
        glare = SpecularGlare(across=across)
        for p in free_parameters(glare):
            for times in (1.0, 3.0):
                by = step_from(getattr(glare, p.name), p, times)
                assert by != 0
                dataclasses.replace(glare, **{p.name: getattr(glare, p.name) + by})


def test_a_strength_by_colour_is_turned_colour_by_colour() -> None:
    light = AmbientLight(rate_e_per_s=Colours(R=100.0, G=50.0, B=0.0), share_in_dark=1.0)
    rate = next(p for p in light.parameters() if p.name == "rate_e_per_s")
    red, green = handles_of(light, rate, ("R", "G", "B"))
    assert (red.channel, green.channel) == (0, 1)  # blue is off
    turned = moved(light, {red: 10.0, green: -80.0})
    assert turned == dataclasses.replace(light, rate_e_per_s=Colours(R=110.0, G=0.0, B=0.0))
    assert handles_of(light, rate, ("Y",)) == []
    share = next(p for p in light.parameters() if p.name == "share_in_dark")
    whole = Handle(effect="ambient_light", parameter="share_in_dark")
    assert handles_of(light, share, ("R", "G", "B")) == [whole]


def test_a_strength_that_may_differ_by_colour_is_sought_in_each() -> None:
    alone = [one.rate_e_per_s for one in starts(AmbientLight)]
    only = [rate for rate in alone if isinstance(rate, Colours)]
    assert [tuple(rate > 0 for rate in one) for one in only] == [
        (True, False, False),
        (False, True, False),
        (False, False, True),
    ]
    twice = scaled(AmbientLight(rate_e_per_s=Colours(R=100.0, G=50.0, B=0.0)), 2.0)
    assert twice.rate_e_per_s == Colours(R=200.0, G=100.0, B=0.0)


def test_no_search_begins_with_what_a_level_takes_up_to_the_last_digit() -> None:
    """A colour that is brighter as a whole is as bright as another level of its lamps makes it."""
    assert {one.response_change for one in starts(SpectralResponseError)} == {0.0}


def test_a_strength_that_no_camera_has_does_nothing() -> None:
    """A ten-thousandth of the usual strength is nothing, a hundredth is not, of every effect that
    has one; a power of 1.0000002 moves no code but by where it sends halves."""
    for kind in catalogue().values():
        usual = kind()
        if kind.base or scaled(usual, 0.5) == usual or any(p.whole for p in kind.parameters()):
            continue
        assert does_nothing(scaled(usual, 1e-4)), kind.name
        assert not does_nothing(scaled(usual, 1e-2)), kind.name
    assert does_nothing(Gamma(exponent=1.0000002))
    assert not does_nothing(Gamma(exponent=0.99))


def test_factors_do_nothing_without_one_of_them() -> None:
    assert does_nothing(DustShadow(depth=0.0))
    assert does_nothing(DustShadow(number=0.0))
    assert not does_nothing(VignettingExcess(k2=0.0))


def test_an_effect_of_two_strengths_is_tried_with_the_other_one_and_with_both() -> None:
    rows = BlackLevelDrift(row_sigma_e=5.0, frame_sigma_e=0.0)
    on = {(one.row_sigma_e > 0, one.frame_sigma_e > 0) for one in of_other_strengths(rows)}
    assert on == {(False, True), (True, True)}
    assert of_other_strengths(Gamma(exponent=0.9)) == []


def test_strengths_that_are_off_are_added_to_those_that_were_fitted() -> None:
    rows = BlackLevelDrift(row_sigma_e=5.0, row_length=33.0, frame_sigma_e=0.0)
    begins = BlackLevelDrift().frame_sigma_e
    assert with_more_strengths(rows) == [dataclasses.replace(rows, frame_sigma_e=begins)]
    assert with_more_strengths(BlackLevelDrift()) == []
    assert with_more_strengths(Gamma(exponent=0.9)) == []
