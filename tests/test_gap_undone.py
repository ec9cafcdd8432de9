"""Where a camera begins that changes its output: in front of that change."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.camera.light import Rate
from analysis.gap.diagnose import calibrated
from analysis.gap.look.curve import powered
from analysis.gap.measure.measured import measured
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.setting import Setting, look
from analysis.gap.ready.undone import unbent
from sensor.frames import Capture
from sensor.record import record
from tests.short import PROTOCOL, camera, light

LAMP = "lamp"
BLACK_DN = camera().black_dn


def photographed() -> Capture:
    return record(camera(), PROTOCOL, {LAMP: light().rate_e_per_s})


def looked_at(capture: Capture) -> Setting:
    setting = look(capture, {})
    assert setting is not None
    return setting


def power_of(rate: Rate) -> float:
    """The power of the light that green was read as."""
    there, read = light().rate_e_per_s[..., 1], rate[..., 1]
    lit = there > 0.2 * there.max()
    return float(np.polyfit(np.log(there[lit]), np.log(read[lit]), 1)[0])


def test_light_is_read_in_front_of_the_curve_that_frames_tell() -> None:
    """Codes above black to the power 0.6 of their part of the range: the frames show light to that
    power, and behind the curve's inverse they show it as it is."""
    exponent = 0.6
    capture = photographed()
    top = capture.frames[0].top_dn
    codes = powered(np.arange(top + 1.0), top, BLACK_DN, exponent)
    table = np.clip(np.round(codes), 0, top).astype(np.uint8)
    bent = tuple(dataclasses.replace(f, dn=table[f.dn]) for f in capture.frames)
    setting = looked_at(dataclasses.replace(capture, frames=bent))
    assert not setting.scenery.light.in_electrons
    shown = setting.scenery.light.rates[LAMP]
    begun = unbent(setting, DirectReading(hints={"exponent": exponent}))
    assert begun.scenery is not None
    assert power_of(shown) == pytest.approx(exponent, abs=0.02)
    assert power_of(begun.scenery.light.rates[LAMP]) == pytest.approx(1.0, abs=0.02)


def test_a_camera_whose_light_nobody_states_is_no_gap() -> None:
    """Patches of a chart, read from the frames with their edges."""
    setting = looked_at(photographed())
    assert not setting.scenery.light.known
    assert measured(calibrated(setting, None), setting.seen).whole.p_value > 1e-3
