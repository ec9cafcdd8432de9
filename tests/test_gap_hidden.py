"""A spread of dark current is found where rounding hides it from the moments of the darks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.calibrate.darks import darks_of
from analysis.gap.calibrate.first_guess import dark_spread2, first_guess
from analysis.gap.diagnose import calibrated
from analysis.gap.look.arithmetic import OF_QUARTERS
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import Setting, halves, look
from sensor.colours import Colours
from sensor.effects.dark_shot import DarkShot
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Shot
from sensor.record import record
from tests.short import PROTOCOL, camera, light

FPN_DN, GAIN = 0.12, 0.023
SHORT_S, LONG_S = 0.012, 0.033


def setting_of_quiet_darks(read_dn: float, spread_e_per_s: float) -> Setting:
    """Darks of 3.5 and 3.9 DN, of which the longer ones are the quieter, behind a converter of
    quarter codes: halves of codes go to the even one, so that code 4 is wider than one DN."""
    dark = (
        Shot(label="short", exposure_s=SHORT_S, frames=16),
        Shot(label="long", exposure_s=LONG_S, frames=16),
    )
    made = dataclasses.replace(camera(), gain_dn_per_e=Colours.of(GAIN), black_dn=3.2)
    made = made.plus(
        ReadNoise(reset_e=0.0, thermal_e=read_dn / GAIN, other_e=0.0),
        Fpn(sigma_e=FPN_DN / GAIN),
        Demosaic(arithmetic=float(OF_QUARTERS)),
        DarkShot(current_e_per_s=800.0, shown_e_per_s=800.0, spread_e_per_s=spread_e_per_s),
    )
    protocol = dataclasses.replace(PROTOCOL, shot=(*dark, *PROTOCOL.shot[1:]))
    taken = record(made.with_body(7), protocol, {"lamp": light().rate_e_per_s}, seed=7)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    return setting


def told_by_moments(setting: Setting) -> float:
    """The spread in e-/s that darks tell by themselves."""
    half, _ = halves(setting.seen)
    dark = darks_of(half, setting.scenery, setting.black_dn)
    assert dark.quiet
    base = first_guess(half, setting.scenery, None, dark)
    exposures_s = np.array([shot.exposure_s for shot in setting.scenery.shots])
    return float(np.sqrt(dark_spread2(half, exposures_s, dark, base.gain_dn_per_e)))


@pytest.mark.whole
@pytest.mark.parametrize(("read_dn", "spread_e_per_s"), [(0.27, 150.0), (0.3, 200.0)])
def test_a_spread_that_rounding_hides_is_calibrated(read_dn: float, spread_e_per_s: float) -> None:
    """In the long dark its pattern is 150 to 200 e-/s x 33 ms x 0.023 DN/e- = 0.11 to 0.15 DN, as
    much as the fixed offsets. Of 10^4 photosites in three colours rounding leaves a third, which
    tell a standard deviation to 2 %, and three times that of the difference of two of them."""
    setting = setting_of_quiet_darks(read_dn, spread_e_per_s)
    assert told_by_moments(setting) < 0.5 * spread_e_per_s
    known = calibrated(setting, None)
    assert known.base.dark_spread2**0.5 == pytest.approx(spread_e_per_s, rel=0.12)
    assert np.sqrt(known.base.fpn_dn2) == pytest.approx(FPN_DN, rel=0.12)
    assert measured(known, setting.seen).whole.p_value > 0.01


@pytest.mark.whole
def test_no_spread_is_made_up_where_there_is_none() -> None:
    setting = setting_of_quiet_darks(0.3, 0.0)
    known = calibrated(setting, None)
    assert known.base.dark_spread2**0.5 < 0.2 * 150.0
    assert measured(known, setting.seen).whole.p_value > 0.01
