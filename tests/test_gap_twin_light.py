"""The light of a twin in DN, which has no noise:

    DN = black + gain x (level x S x rate + dark current that shows) x exposure

with S of an effect that acts on light, and 1 of everything behind it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.camera.light_blocks import blocks_of
from analysis.gap.camera.twin import exposure_of
from analysis.gap.camera.twin_light import light_means
from analysis.gap.ready.setting import look
from analysis.identifiability.known import base_of
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.smear import Smear
from sensor.effects.vignetting_excess import VignettingExcess
from sensor.record import record
from tests.short import HEIGHT, PROTOCOL, WIDTH, camera, light
from tests.twins import twin

K2 = 0.1
LAMP = "lamp"
FOUND = look(record(camera(), PROTOCOL, {LAMP: light().rate_e_per_s}), {LAMP: light()})
assert FOUND is not None
SCENERY = FOUND.scenery
BASE = base_of(camera(), [LAMP])


def stated(shading: np.ndarray | float = 1.0) -> np.ndarray:
    """The closed form, (shots, channels, blocks)."""
    rate = light().rate_e_per_s * shading
    blocks = blocks_of(rate.astype(np.float32), SCENERY.view, BASE.channels)
    dn_per_s = (BASE.gain_dn_per_e * BASE.level[LAMP])[:, None] * blocks
    shown = BASE.gain_dn_per_e[:, None] * BASE.shown_e_per_s
    return np.array(
        [
            0 * dn_per_s
            if s.dark
            else BASE.black_dn[:, None] + dn_per_s * exposure_of(s) + shown * s.exposure_s
            for s in SCENERY.shots
        ]
    )


def test_light_alone_is_the_light_that_was_stated() -> None:
    assert light_means(SCENERY, BASE) == pytest.approx(stated(), rel=1e-5)


def test_an_effect_of_the_light_is_in_it_and_one_behind_is_not() -> None:
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    r2 = (y - (HEIGHT - 1) / 2) ** 2 + (x - (WIDTH - 1) / 2) ** 2
    shading = 1 - K2 * r2 / (HEIGHT**2 + WIDTH**2) * 4
    effects = [Smear(leak_ratio=0.1), VignettingExcess(k2=K2, k4=0.0)]
    found = light_means(SCENERY, BASE, effects=effects)
    assert found == pytest.approx(stated(shading[..., None]), rel=1e-4)


def test_light_that_changes_is_looked_at_frame_by_frame() -> None:
    """Of a lamp that drifts the mean of all frames counts, as it does in the frames of a twin."""
    drift = [LampDrift(change=0.2)]
    noisy = (
        twin(SCENERY, BASE, effects=drift, seed=3).means[0] - twin(SCENERY, BASE, seed=3).means[0]
    )
    change = light_means(SCENERY, BASE, effects=drift, seed=3) - light_means(SCENERY, BASE, seed=3)
    lit = [k for k, shot in enumerate(SCENERY.shots) if not shot.dark]
    assert change[lit].mean() == pytest.approx(noisy[lit].mean(), rel=0.02)


def test_light_that_falls_everywhere_is_a_dark_current() -> None:
    """So much more of one and less of the other is the same picture, and no light to give back."""
    rate = 900.0
    less = dataclasses.replace(BASE, shown_e_per_s=BASE.shown_e_per_s - rate)
    even = [AmbientLight(rate_e_per_s=rate, share_in_dark=1.0)]
    assert light_means(SCENERY, less, effects=even, seed=3) == pytest.approx(
        light_means(SCENERY, BASE, seed=3), rel=1e-4
    )
