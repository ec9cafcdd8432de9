"""Captures of darks alone: a camera is calibrated to them, and no light is missed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.diagnose import calibrated, diagnose
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import Setting, look
from camtruth.report.gap import answer
from sensor.camera import GREY, Camera
from sensor.colours import Colours
from sensor.effects.dark_shot import DarkShot
from sensor.effects.demosaic import Demosaic
from sensor.effects.row_noise import RowNoise
from sensor.frames import Capture
from sensor.protocol import Protocol, Shot
from sensor.record import record
from tests.short import HEIGHT, WIDTH, camera

DARKS = Protocol(
    name="darks",
    shot=tuple(
        Shot(label=f"dark {exposure_s}", exposure_s=exposure_s, frames=16)
        for exposure_s in (0.01, 0.1, 1.0)
    ),
)
GAIN = Colours(R=0.5, G=0.4, B=0.44)


def taken(cfa: str, gain: Colours, *effects: RowNoise) -> Capture:
    """Darks of a raw camera of 12 bits, of which the longest gathers 300 e-."""
    pixels = "mono16" if cfa == GREY else "bayer16"
    gathering = DarkShot(current_e_per_s=300.0, shown_e_per_s=300.0)
    made: Camera = dataclasses.replace(
        camera().without(Demosaic).plus(gathering, *effects),
        pixels=pixels,
        bits=12,
        cfa=cfa,
        gain_dn_per_e=gain,
        black_dn=200.0,
    )
    none = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    return record(made.with_body(5), DARKS, {"lamp": none}, seed=5)


def looked(capture: Capture) -> Setting:
    setting = look(capture, {})
    assert setting is not None
    return setting


@pytest.mark.parametrize(("cfa", "gain"), [("GRBG", GAIN), (GREY, Colours.of(0.4))])
def test_darks_of_a_camera_like_the_model_are_matched(cfa: str, gain: Colours) -> None:
    """There is nothing that light could take up. What gathers, 120 DN and more, tells gains of
    colours over that of green: its mean has an error of 0.3 DN by the offsets of 3,072 photosites.
    Its shot noise, 48 DN^2 beside 144 in 3,072 samples of 8 frames, tells the gain itself: to 4 %
    by each channel."""
    setting = looked(taken(cfa, gain))
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 0.01
    true = [gain.G] if cfa == GREY else list(gain)
    assert list(known.base.gain_dn_per_e) == pytest.approx(true, rel=0.1)
    if cfa != GREY:
        red, green, blue = known.base.gain_dn_per_e
        assert red / green == pytest.approx(gain.R / gain.G, abs=0.02)
        assert blue / green == pytest.approx(gain.B / gain.G, abs=0.02)


@pytest.mark.whole
def test_an_effect_in_darks_is_named_alone() -> None:
    """Gains that differ by colour are calibrated, and no white balance."""
    report = diagnose(taken("GRBG", GAIN, RowNoise(sigma_e=10.0))).report
    assert [one.name for one in report.effects] == ["row_noise"], answer(report)
    (named,) = report.effects
    assert named.probability > 0.5
    assert named.parameters["sigma_e"].value == pytest.approx(10.0, rel=0.15)
