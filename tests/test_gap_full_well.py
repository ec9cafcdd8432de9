"""Full photosites are told by where pictures end, and their camera by what is well below."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from analysis.gap.ready.brimful import brimful
from analysis.gap.ready.setting import Setting, look
from sensor.effects.blooming import Blooming
from sensor.effects.nonlinearity import Nonlinearity
from sensor.frames import Capture
from sensor.record import record
from tests.short import PROTOCOL, camera, light

FULL_E = 4000.0
"""The brightest patches have 3,000 in the dim shot and 7,600 in the bright one."""

FULL_IN_EVERY_SHOT_E = 2200.0


def taken(*effects: Blooming) -> Capture:
    """A dark, a dim and a bright shot."""
    made = camera().plus(*effects).with_body(5)
    return record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)


def setting_of(capture: Capture) -> Setting:
    setting = look(capture, {"lamp": light()})
    assert setting is not None
    return setting


@pytest.mark.parametrize("full_e", [FULL_E, FULL_IN_EVERY_SHOT_E])
def test_the_camera_of_full_photosites_is_told_by_what_is_well_below(full_e: float) -> None:
    """Samples that are not full tell the gain to sqrt(2 / n) of n of them and frames, and to what
    medians of variances in whole codes are off, 3 %. The brightest hundredth of those that are
    tell the product with the full well: they lie some 2.7 standard deviations above it, of 0.25 DN
    of offsets and noise in the mean of 16 frames. The darkest blocks tell the light, which is 1
    here, to as much as its gain and to what runs over into all of them."""
    told = brimful(setting_of(taken(Blooming(full_well_e=full_e, drained=0.8))))
    assert told is not None
    assert told.base is not None
    found_e = told.hints["full_well_e"]
    assert isinstance(found_e, float)
    gain = np.array([*camera().gain_dn_per_e])
    above_dn = told.base.gain_dn_per_e * found_e - gain * full_e
    np.testing.assert_allclose(above_dn, 0.0, atol=2.7 * 0.25)
    assert found_e == pytest.approx(full_e, rel=3 * 0.03)
    bright = told.base.level["lamp"] * told.base.gain_dn_per_e / gain
    np.testing.assert_allclose(bright, 1.0, atol=0.03)
    assert told.instead is not None
    assert told.instead.hints["drained"] == 0.0


def test_nothing_is_told_of_photosites_that_are_not_full() -> None:
    assert brimful(setting_of(taken())) is None


@pytest.mark.whole
def test_blooming_is_named_under_the_light_that_was_stated() -> None:
    """A base that knows no full photosites makes the light as flat as they are, and under such a
    light nothing fills them: the search begins under the stated one."""
    capture = taken(Blooming(full_well_e=FULL_E, drained=0.8))
    found = diagnose(capture, stated={"lamp": light()}, suspects=[Blooming, Nonlinearity]).report
    assert [e.name for e in found.effects] == ["blooming"]
    blooming = found.effects[0].parameters
    assert blooming["full_well_e"].value == pytest.approx(FULL_E, rel=3 * 0.03)
    assert blooming["drained"].value == pytest.approx(0.8, abs=0.05)
    assert found.gap.after < 1e-3 * found.gap.before
