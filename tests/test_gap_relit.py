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
from analysis.gap.calibrate.relit import LEAST_DN, lighting, relit
from analysis.gap.camera.light_ways import SHADING_PRIOR
from analysis.gap.camera.twin import Scenery, twin
from analysis.gap.look.observation import Observation
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import Setting, look
from analysis.identifiability.known import base_of
from sensor.effect import Effect
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.vignetting_excess import VignettingExcess
from sensor.record import record
from tests.short import HEIGHT, PROTOCOL, WIDTH, camera, light

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


def seen_with(effect: Effect, scenery: Scenery) -> Observation:
    return twin(scenery, known().base, effects=[effect], seed=3)


def given_back(effect: Effect) -> tuple[Scenery, Observation, Observation]:
    """The light that gives back what an effect takes, a twin under it, and one without either."""
    before = twin(known().scenery, known().base, seed=3)
    see = functools.partial(seen_with, effect)
    scenery = known().scenery
    return *relit(effect, known().lighting, scenery, before, see(scenery), see), before


def shading() -> np.ndarray:
    """S at each pixel."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    middle_y, middle_x = (HEIGHT - 1) / 2, (WIDTH - 1) / 2
    r2 = ((y - middle_y) ** 2 + (x - middle_x) ** 2) / (HEIGHT**2 + WIDTH**2) * 4
    return np.asarray(1 - K2 * r2)[..., None]


def test_the_light_gives_back_what_more_vignetting_takes() -> None:
    """To a thirtieth of it, and to a tenth in the corners, which lie beyond the middle of every
    block: the error of a round is the square of the one before, and means of few frames have
    noise."""
    scenery, _, _ = given_back(DARKER)
    before, after = known().scenery.light.falls[LAMP], scenery.light.falls[LAMP]
    off = after * shading() / before - 1
    assert np.sqrt(np.mean(off**2)) < K2 / 30
    assert np.abs(off).max() < K2 / 10


def test_means_are_those_of_the_stated_light_and_histograms_stay() -> None:
    _, seen, before = given_back(DARKER)
    codes = np.array([k.family == "codes" and k.shot != "dark" for k in before.keys])
    assert seen.keys == before.keys
    once = seen_with(DARKER, known().scenery)
    own, other = (np.abs(s.figures - before.figures)[0, codes] for s in (seen, once))
    # darkened twice patches lie at other parts of a code: figures move ten times as far, or more
    assert np.square(own).sum() < 0.1 * np.square(other).sum()
    dark, *lit = range(len(seen.shots))
    assert seen.means[0, dark] == pytest.approx(before.means[0, dark], abs=0.02)
    for shot in lit:
        assert seen.means[0, shot] == pytest.approx(once.means[0, shot], rel=0.01)


def test_what_happens_behind_the_light_changes_none() -> None:
    """A black level that is ten codes higher is as much as a brighter lamp for one shot, and no
    light. Less than a third of a code is not worth it."""
    for effect in (BlackLevelOffset(offset_e=500.0), VignettingExcess(k2=1e-4, k4=0.0)):
        scenery, _, _ = given_back(effect)
        assert scenery is known().scenery


def test_light_that_nobody_stated_stays_as_the_frames_show_it() -> None:
    unknown = dataclasses.replace(known().scenery.light, known=False)
    scenery = dataclasses.replace(known().scenery, light=unknown)
    assert lighting(known().base, scenery, known().bodies) is None


def test_changes_are_far_apart_where_light_is() -> None:
    """A way that moves the brightest block by 1 DN and an amount of LEAST_DN are that far apart."""
    how = known().lighting
    assert how is not None
    for way, means in enumerate(how.means):
        one = np.zeros(len(how.ways))
        one[way] = LEAST_DN / np.abs(means).max()
        assert how.apart_dn(one, np.zeros_like(one)) == pytest.approx(LEAST_DN)


def test_vignetting_is_known_no_better_than_the_light_is() -> None:
    """One lamp, so one prior for each shading. Histograms that knew where patches lie would know
    it ten times as well."""
    model = around(known().base, known().scenery, [DARKER])
    after = measured(model, setting().seen)
    (error,) = after.errors[len(model.ways.knobs) :][: len(model.ways.tuned)]
    a = WIDTH**2 / (WIDTH**2 + HEIGHT**2)
    best = SHADING_PRIOR / np.hypot(a, 1 - a)
    assert 0.95 * best < error < 3 * best
