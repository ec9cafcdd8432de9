"""Dust is fitted in the space of a camera that has dust.

Of n shadows of depth d and diameter D the light of a block has a variance that grows with
n d^2 D^2, whichever of the three it is; that much frames of one body tell. Areas of shadows, of
diameters from half to three halves of D, scatter by half of their mean, so that 24 of them, some
over the edge, make it known to a tenth or two; 0.6 is three times that.
"""

from __future__ import annotations

import dataclasses
import functools

import pytest

from analysis.gap.calibrate.fit import around
from analysis.gap.calibrate.refine import refined
from analysis.gap.measure.case import Candidate, Case, candidate
from analysis.gap.measure.distance import distance
from analysis.gap.measure.measured import measured
from analysis.gap.measure.signature import signature
from analysis.gap.measure.twins_spread import spread_of
from analysis.gap.ready.setting import look
from analysis.gap.suspects.anew import MISFIT, OFF, SCATTERS, with_its_scatter
from analysis.gap.suspects.fit_scattering import settled
from analysis.identifiability.known import base_of
from sensor.effect import Effect
from sensor.effects.adc_dnl import AdcDnl
from sensor.effects.dust_shadow import DustShadow
from sensor.effects.jpeg import Jpeg
from sensor.effects.veiling_glare import VeilingGlare
from sensor.record import record
from tests.short import PROTOCOL, camera, light

DUST = DustShadow(number=24.0, diameter_px=10.0, depth=0.15)
BEYOND_DOUBT = 1e-20


@functools.cache
def against_the_camera_without(effect: Effect) -> Case:
    """A capture with an effect against the camera without."""
    taken = camera().plus(effect).with_body(5)
    setting = look(
        record(taken, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5), {"lamp": light()}
    )
    assert setting is not None
    known = around(base_of(camera(), ["lamp"]), setting.scenery)
    return measured(known, setting.seen).case


def dusty() -> Case:
    """A capture with dust against the camera without."""
    return against_the_camera_without(DUST)


def begun(case: Case, effect: Effect) -> Candidate:
    """A suspect as it begins."""
    shown = signature(effect, case.known)
    assert shown is not None
    return candidate(case, shown, 0.0)


def power(dust: Effect) -> float:
    """What shadows do to the variance of the light."""
    assert isinstance(dust, DustShadow)
    return dust.number * (dust.depth * dust.diameter_px) ** 2


def left(effect: Effect) -> float:
    """Chance of what a camera with so much dust leaves of the frames that score."""
    case = dusty()
    model = around(case.known.base, case.known.scenery, (effect,))
    seen = model.textured(case.score_seen)
    turned = model.calibration_for(seen)
    spread = spread_of(model, seen.groups)
    return distance(turned.left(turned.space.of(seen)), spread).p_value


@pytest.mark.whole
def test_dust_is_as_much_as_bodies_differ() -> None:
    start = DustShadow()
    assert power(start) < power(DUST) / 10
    assert left(start) < BEYOND_DOUBT
    case = dusty()
    model, _ = settled(case, case.known.base, start)
    found = model.effects[-1]
    assert left(found) > 0.01
    assert power(found) == pytest.approx(power(DUST), rel=0.6)


def test_what_is_told_to_the_last_digit_stays_as_it_is_told() -> None:
    """The camera is turned, the dust is not."""
    case = dusty()
    model, off = settled(case, case.known.base, DUST, tuned=False)
    assert model.effects == (DUST,)
    assert off <= OFF


def test_a_weak_beginning_of_dust_is_settled_and_a_glare_is_not() -> None:
    """By the errors of a camera without dust as little of it as this explains next to nothing; by
    its own most is gone. A veil is the same in every body."""
    case = dusty()
    found = with_its_scatter(case, begun(case, DustShadow()))
    assert found is not None
    assert found.model is not None
    assert found.misfit > MISFIT
    assert found.off <= OFF
    assert left(found.effect) > 0.01
    assert with_its_scatter(case, begun(case, VeilingGlare())) is None


def test_what_few_twins_make_less_of_is_not_settled() -> None:
    """Where another effect does nearly all of it, a suspect that does next to nothing leaves less
    by the errors of few twins than the model does by those of all. So does the model by few. Errors
    of all that are half as wide make chi-squared four times as much.
    """
    case = against_the_camera_without(Jpeg(quality=60))
    case = dataclasses.replace(case, fit_left=2.0 * case.fit_left)
    suspect = begun(case, VeilingGlare())
    own = refined(suspect.base, case.fit_seen, suspect.scenery, (suspect.effect,))
    assert own.misfit < SCATTERS * min(suspect.misfit, case.misfit)
    assert with_its_scatter(case, suspect) is None


def test_a_converter_is_found_of_another_kind_and_strength_than_it_seems() -> None:
    """Codes begin where bits that weigh wrongly put them: the middle one is off by a standard
    deviation of 0.08 sqrt(255) = 1.3 codes. Means of one body look like a flash converter's, whose
    codes are each off by a twentieth. Eight bits are drawn, of which three matter, so that draws
    tell a strength to sqrt(1 / 6) of itself; twice that is allowed."""
    true = AdcDnl(unit_mismatch=0.08)
    case = against_the_camera_without(true)
    seems = begun(case, AdcDnl(unit_mismatch=0.0, threshold_sigma_dn=0.05))
    assert case.bare.misfit > 1.0 / SCATTERS
    found = with_its_scatter(case, seems)
    assert found is not None
    assert isinstance(found.effect, AdcDnl)
    assert found.effect.threshold_sigma_dn == 0.0
    assert found.effect.unit_mismatch == pytest.approx(true.unit_mismatch, rel=2 * 6**-0.5)
    assert found.off < OFF
