"""Light that gives back what an effect takes off it, where calibration has taken that up.

    light' S = light,    so that no histogram moves, while mean images are those of the stated light

with S = 1 - k2 r^2 of more vignetting. Of it and of what nobody knows of the light the mean images
tell the sum alone. S is k2 (a x^2 + b y^2) with a = w^2 / (w^2 + h^2) and b = 1 - a, if x and y are
1 at the sides, and either shading has a prior p, so that k2 is known to

    p / sqrt(a^2 + b^2)

at best, however many frames there are.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.calibrate.relit import lighting, relit
from analysis.gap.camera.base import Base
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_blocks import blocks_of
from analysis.gap.camera.light_ways import SHADING_PRIOR, changed, image_ways, light_ways
from analysis.gap.camera.surface import SHAPES
from analysis.gap.camera.twin import Scenery, exposure_of
from analysis.gap.camera.twin_light import light_means
from analysis.gap.look.observation import Observation
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import Setting, look
from analysis.identifiability.known import base_of
from sensor.effect import Effect
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.lamp_displacement import LampDisplacement
from sensor.effects.spectral_response_error import SpectralResponseError
from sensor.effects.vignetting_excess import VignettingExcess
from sensor.record import record
from tests.short import HEIGHT, PROTOCOL, WIDTH, camera, light
from tests.twins import twin

K2 = 0.1
DARKER = VignettingExcess(k2=K2, k4=0.0)
LAMP = "lamp"


@functools.cache
def setting() -> Setting:
    made = look(record(camera(), PROTOCOL, {LAMP: light().rate_e_per_s}), {LAMP: light()})
    assert made is not None
    return made


@functools.cache
def known() -> Fit:
    return around(base_of(camera(), [LAMP]), setting().scenery)


def seen_with(effect: Effect, base: Base, scenery: Scenery) -> Observation:
    return twin(scenery, base, effects=[effect], seed=3)


def given_back(effect: Effect) -> tuple[Base, Scenery, Observation, Observation]:
    """The light that gives back what an effect takes, a twin under it, and one without either."""
    base, scenery = known().base, known().scenery
    before = twin(scenery, base, seed=3)
    base, scenery = relit(known().lighting, base, scenery, before=(), after=[effect], seed=3)
    return base, scenery, seen_with(effect, base, scenery), before


def shading() -> np.ndarray:
    """S at each pixel."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    middle_y, middle_x = (HEIGHT - 1) / 2, (WIDTH - 1) / 2
    r2 = ((y - middle_y) ** 2 + (x - middle_x) ** 2) / (HEIGHT**2 + WIDTH**2) * 4
    return np.asarray(1 - K2 * r2)[..., None]


@pytest.mark.whole
def test_the_light_gives_back_what_more_vignetting_takes() -> None:
    """To a thirtieth of it, and to a tenth in the corners, which lie beyond the middle of every
    block: means of few frames have noise."""
    base, scenery, _, _ = given_back(DARKER)
    before, after = known().scenery.light.falls[LAMP], scenery.light.falls[LAMP]
    brighter = base.level[LAMP] / known().base.level[LAMP]
    off = brighter * after * shading() / before - 1
    assert np.sqrt(np.mean(off**2)) < K2 / 30
    assert np.abs(off).max() < K2 / 10


def test_a_level_is_the_cameras_and_shading_is_held_against_the_light() -> None:
    """In the middle of the field a lamp that hangs s higher over the chart than l_z lights it by

        (1 + s / l_z) (1 + (2 l_z s + s^2) / R^2)^(-3/2)

    as much: of a camera that was calibrated without that, its level is as much too low. Mean images
    are held against the stated light, with the effect and with that level."""
    higher = LampDisplacement(right_cm=0.0, away_cm=5.0)
    height = higher.lamp_away_cm
    r2 = higher.lamp_up_cm**2 + height**2
    at_the_middle = (1 + 5 / height) * (1 + (10 * height + 25) / r2) ** -1.5
    base, _, seen, before = given_back(higher)
    brighter = base.level[LAMP] / known().base.level[LAMP]
    assert brighter * at_the_middle == pytest.approx(1.0, abs=2e-3)
    dark, *lit = range(len(seen.shots))
    assert seen.means[0, dark] == pytest.approx(before.means[0, dark], abs=0.02)
    once = seen_with(higher, base, known().scenery)
    for shot in lit:
        assert seen.means[0, shot] == pytest.approx(once.means[0, shot], rel=0.02)


def test_histograms_stay() -> None:
    _, _, seen, before = given_back(DARKER)
    codes = np.array([k.family == "codes" and k.shot != "dark" for k in before.keys])
    assert seen.keys == before.keys
    once = seen_with(DARKER, known().base, known().scenery)
    own, other = (np.abs(s.figures - before.figures)[0, codes] for s in (seen, once))
    # darkened twice patches lie at other parts of a code: figures move ten times as far, or more
    assert np.square(own).sum() < 0.1 * np.square(other).sum()


def test_what_happens_behind_the_light_changes_none() -> None:
    """A black level that is ten codes higher is as much as a brighter lamp for one shot, and no
    light. Less than a twentieth of a code is not worth it."""
    for effect in (BlackLevelOffset(offset_e=500.0), VignettingExcess(k2=1e-5, k4=0.0)):
        base, scenery, _, _ = given_back(effect)
        assert base is known().base
        assert scenery is known().scenery


def test_light_that_effects_make_brighter_is_given_back_as_well() -> None:
    """Responses that are three times as high show three times of what is taken off the light: one
    that is a third as strong, seen through them, is darkened by more vignetting as any other."""
    brighter = SpectralResponseError(leakage=0.0, response_change=2.0)
    base = dataclasses.replace(
        known().base, level={lamp: level / 3 for lamp, level in known().base.level.items()}
    )
    reference = twin(known().scenery, base, effects=[brighter], seed=3)
    how = lighting(base, known().scenery, reference)
    lit, scenery = relit(
        how, base, known().scenery, before=[brighter], after=[brighter, DARKER], seed=3
    )
    before = light_means(known().scenery, base, effects=[brighter], seed=3)
    after = light_means(scenery, lit, effects=[brighter, DARKER], seed=3)
    once = light_means(known().scenery, base, effects=[brighter, DARKER], seed=3)
    assert np.abs(after - before).max() < 0.1 * np.abs(once - before).max()


def test_clipped_blocks_tell_nothing_of_a_change() -> None:
    """Of light that is a tenth darker wherever a picture is not clipped, the level is a tenth, how
    little the rest may seem to change."""
    reference, scenery = known().bodies, known().scenery
    _, first, *_ = range(len(reference.shots))
    half = reference.means.shape[-1] // 2
    means = reference.means.copy()
    means[:, first, :, :half] = scenery.view.top_dn
    clipped = dataclasses.replace(reference, means=means)
    how = lighting(known().base, scenery, clipped)
    assert how is not None
    darker = -0.1 * how.means[: len(how.levels)].sum(axis=0)
    darker[first, :, :half] = 0.0
    levels, ways = how.amounts(darker)
    assert levels == pytest.approx(-0.1, abs=1e-3)
    assert np.abs(ways).max() < 1e-3


def test_a_clipped_block_moves_by_no_light() -> None:
    """A block at the largest code stays there whatever the light does: none of its ways moves it,
    and they move the others as they did."""
    scenery, reference = known().scenery, known().bodies
    top = np.zeros(reference.means.shape[1:], dtype=bool)
    top[-1, :, 3] = True
    means = np.where(top, float(scenery.view.top_dn), reference.means)
    clipped = dataclasses.replace(reference, means=means)
    for before, after in zip(
        light_ways(known().base, scenery, reference),
        light_ways(known().base, scenery, clipped),
        strict=True,
    ):
        assert np.array_equal(after.means, np.where(top, 0.0, before.means))


def test_any_surface_may_be_the_light_that_was_laid_through_the_frames() -> None:
    """What ways do to blocks is what they do to rate images, seen at the level of each shot, to
    single precision."""
    light = dataclasses.replace(known().scenery.light, in_electrons=False)
    scenery = dataclasses.replace(known().scenery, light=light)
    base, view = known().base, scenery.view
    ways = list(image_ways(base, scenery, known().bodies))
    assert len(ways) == (SHAPES - 1) * len(base.channels) * len(light.rates)
    amounts = 1e-3 * light.rates[LAMP].mean() * np.random.default_rng(4).normal(size=len(ways))
    shown = changed(light, light.rates, ways, amounts)
    found = np.tensordot(amounts, [way.means for way in ways], axes=1)
    for shot, of_shot in zip(scenery.shots, found, strict=True):
        if shot.dark:
            assert not of_shot.any()
            continue
        lamp = lamp_of(shot)
        brighter = blocks_of(shown.falls[lamp] - light.rates[lamp], view, base.channels)
        dn = (base.level[lamp] * base.gain_dn_per_e)[:, None] * brighter * exposure_of(shot)
        assert of_shot == pytest.approx(dn, abs=1e-4 * np.abs(dn).max())


def test_light_that_nobody_stated_stays_as_the_frames_show_it() -> None:
    unknown = dataclasses.replace(known().scenery.light, known=False)
    scenery = dataclasses.replace(known().scenery, light=unknown)
    assert lighting(known().base, scenery, known().bodies) is None


def test_vignetting_is_known_no_better_than_the_light_is() -> None:
    """One lamp, so one prior for each shading. Histograms that knew where patches lie would know
    it ten times as well."""
    model = around(known().base, known().scenery, [DARKER])
    after = measured(model, setting().seen)
    (error,) = after.errors[len(model.ways.knobs) :][: len(model.ways.tuned)]
    a = WIDTH**2 / (WIDTH**2 + HEIGHT**2)
    best = SHADING_PRIOR / np.hypot(a, 1 - a)
    assert 0.95 * best < error < 3 * best
