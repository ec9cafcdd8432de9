"""A camera whose darks JPEG has emptied begins with what lit shots tell of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.ready.jpeg import behind_blocks
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import look
from analysis.gap.suspects.direct_readings import told_by
from sensor.effects.jpeg import Jpeg
from sensor.record import record
from tests.short import PROTOCOL, camera, light


def test_black_level_and_noise_are_given_back_behind_a_coarse_table() -> None:
    """Of quality 60 a step of the mean of a block is 1.6 DN, and darks have one code, 0.7 DN off.
    Lit shots point to their level to 0.1. Red has twice its gain, blue three times, and green, of
    which luminance keeps most, 1.4 times.
    """
    true = dataclasses.replace(camera(), black_dn=6.7)
    made = true.plus(Jpeg(quality=60.0)).with_body(5)
    capture = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)
    setting = look(capture, {"lamp": light()})
    assert setting is not None
    first = by_moments(setting)[1]
    base = behind_blocks(setting, first)
    assert base is not None
    assert abs(first.black_dn.mean() - true.black_dn) > 0.5
    np.testing.assert_allclose(base.black_dn, true.black_dn, atol=0.2)
    gain = true.gain_dn_per_e.G
    assert min(first.gain_dn_per_e[[0, 2]]) > 2 * gain
    np.testing.assert_allclose(base.gain_dn_per_e, gain, rtol=0.5)
    assert base.read_dn2 == pytest.approx(ROUNDING_DN2)
    bright = base.level["lamp"] * base.gain_dn_per_e
    np.testing.assert_allclose(bright, first.level["lamp"] * first.gain_dn_per_e)
    told = told_by(setting, first)[Jpeg.name]
    assert told.base is None
    assert told.instead is not None
    assert told.instead.base is not None
    assert told.instead.hints == told.hints == {"quality": 60.0}
