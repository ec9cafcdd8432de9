"""The camera of a picture that trembles is told by what is even in it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, look
from analysis.gap.ready.vibration import trembling
from render.rate import RateImage
from sensor.effect import Effect
from sensor.effects.vibration import Vibration
from sensor.record import record
from tests.short import PROTOCOL, camera, light


def hard() -> RateImage:
    """Patches whose edges are those of pixels, (H, W, 3)."""
    soft = light()
    height, width = soft.rate_e_per_s.shape[:2]
    patches = np.random.default_rng(12).uniform(0.1, 1.0, (height // 24, width // 32, 3))
    rate = 4.5e5 * np.kron(patches, np.ones((24, 32, 1)))
    return dataclasses.replace(soft, rate_e_per_s=rate.astype(np.float32))


def setting(*effects: Effect) -> Setting:
    taken = record(camera().plus(*effects).with_body(3), PROTOCOL, {"lamp": hard().rate_e_per_s})
    found = look(taken, {"lamp": hard()})
    assert found is not None
    return found


def test_edges_that_go_to_and_fro_are_no_shot_noise() -> None:
    """By all samples a gain is several times too high, by medians of those as bright as each other
    and of levels it is right to a fifth: a quarter of them lie at an edge."""
    moving = setting(Vibration(shift_px=0.3, blur_px=0.0))
    _, usual = by_moments(moving)
    assert (usual.gain_dn_per_e > 2 * 0.02).all()
    told = trembling(moving)
    assert told is not None
    assert told.base is not None
    assert not told.exact
    assert told.base.gain_dn_per_e == pytest.approx(0.02, rel=0.2)


def test_a_steady_picture_does_not_tremble() -> None:
    assert trembling(setting()) is None
