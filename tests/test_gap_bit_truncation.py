"""A camera that has lost bits begins with the noise that lit shots have in front of its steps."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.ready.bit_truncation import behind_steps
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, look
from sensor.camera import Camera
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.read_noise import ReadNoise
from sensor.effects.white_balance import WhiteBalance
from sensor.record import record
from tests.short import PROTOCOL, camera, light


def taken(made: Camera, *effects: BitTruncation | WhiteBalance) -> Setting:
    """A dark, a dim and a bright shot."""
    body = made.plus(*effects).with_body(5)
    capture = record(body, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)
    setting = look(capture, {"lamp": light()})
    assert setting is not None
    return setting


BITS = BitTruncation(bits=2.0)
BALANCE = WhiteBalance(red_gain=1.3, blue_gain=0.8)


@pytest.mark.parametrize("effects", [(BITS,), (BITS, BALANCE)])
def test_noise_and_black_level_of_lit_shots_are_those_in_front_of_steps(
    effects: tuple[BitTruncation | WhiteBalance, ...],
) -> None:
    """Noise of 0.6 DN behind steps of 4 looks twice as loud. Of one level it is anything from none
    to 2 DN by where that lies between two steps; some 100 patches and their slopes leave 7 % of a
    gain, and as much of a step in the black level as they leave of its mean, 0.04."""
    setting = taken(camera(), *effects)
    told = setting.told[BITS.name]
    first = by_moments(setting)[1]
    if setting.counting.gains:
        gains = setting.counting.gains[0]
        first = first.multiplied(gains.white_balance, gains.origin_dn)
    assert (first.white_balance is None) is (BALANCE not in effects)
    base = behind_steps(setting, told, first)
    assert base is not None
    true = camera()
    gain = true.gain_dn_per_e.G
    assert first.gain_dn_per_e.mean() > 1.5 * gain
    np.testing.assert_allclose(base.gain_dn_per_e, gain, rtol=3 * 0.07)
    assert base.gain_dn_per_e.mean() == pytest.approx(gain, rel=3 * 0.07 / np.sqrt(3))
    np.testing.assert_allclose(base.black_dn, true.black_dn, atol=3 * 0.04)
    bright = base.level["lamp"] * base.gain_dn_per_e
    np.testing.assert_allclose(bright, first.level["lamp"] * first.gain_dn_per_e)


@pytest.mark.parametrize(("read_e", "hidden"), [(30.0, True), (80.0, False)])
def test_darks_that_show_their_noise_tell_it_themselves(read_e: float, hidden: bool) -> None:
    """Noise of 0.6 and of 1.6 DN behind steps of 2."""
    louder = camera().plus(ReadNoise(reset_e=0.0, thermal_e=read_e, other_e=0.0))
    setting = taken(louder, BitTruncation(bits=1.0))
    found = behind_steps(setting, setting.told[BITS.name], by_moments(setting)[1])
    assert (found is not None) is hidden
