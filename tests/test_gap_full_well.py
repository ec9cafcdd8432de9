"""Full photosites are told by where pictures end, and their camera by shots without any."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from analysis.gap.ready.full_well import brimful
from analysis.gap.ready.setting import Setting, look
from sensor.effects.blooming import Blooming
from sensor.effects.nonlinearity import Nonlinearity
from sensor.frames import Capture
from sensor.record import record
from tests.short import PROTOCOL, camera, light

FULL_E = 4000.0
"""The brightest patches have 3,000 in the dim shot and 7,600 in the bright one."""


def taken(*effects: Blooming) -> Capture:
    """A dark, a dim and a bright shot."""
    made = camera().plus(*effects).with_body(5)
    return record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)


def setting_of(capture: Capture) -> Setting:
    setting = look(capture, {"lamp": light()})
    assert setting is not None
    return setting


@pytest.mark.whole
def test_the_camera_of_full_photosites_is_told_by_the_shots_without_any() -> None:
    """The dim shot tells the gain to sqrt(2 / n) of its n pixels and frames and to what patches
    scatter, 3 %; the level at which the bright one ends tells the product with the full well to a
    thousandth. Without full photosites, or with no other shots, nothing is told."""
    told = brimful(setting_of(taken(Blooming(full_well_e=FULL_E, drained=0.8))))
    assert told is not None
    assert told.base is not None
    full_e = told.hints["full_well_e"]
    assert isinstance(full_e, float)
    gain = camera().gain_dn_per_e
    ratio = told.base.gain_dn_per_e * full_e / (np.array([*gain]) * FULL_E)
    np.testing.assert_allclose(ratio, 1.0, atol=0.01)
    assert full_e == pytest.approx(FULL_E, rel=3 * 0.03)
    assert told.instead is not None
    assert told.instead.hints["drained"] == 0.0
    assert brimful(setting_of(taken())) is None
    assert brimful(setting_of(taken(Blooming(full_well_e=2200.0)))) is None


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
