"""Three sensors behind a prism: every pixel is measured in three colours, each by its own body."""

from __future__ import annotations

import dataclasses
import math
import warnings

import numpy as np
import pytest

from analysis.estimators.irie import irie
from analysis.gap.camera.base import camera_of
from analysis.gap.diagnose import calibrated
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import look
from foundation.backend import backend
from sensor.camera import PRISM
from sensor.camera_file import load, write
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.image_lag import ImageLag
from sensor.effects.lamp_flicker import LampFlicker
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.read_noise import ReadNoise
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.errors import CameraError
from sensor.frames import Capture, Pixels, TooFewFrames
from sensor.protocol import Protocol
from sensor.record import record
from sensor.simulation import pixels_of, simulate
from sensor.truth import realised
from tests.backends import BACKENDS
from tests.harness import assert_agree, variance_error
from tests.plain_camera import GAIN, LIT, RATE, SIDE, camera, dn
from tests.short import PROTOCOL, light
from tests.short import camera as short_camera

THREE = {"cfa": PRISM, "pixels": "rgb8", "bits": 8}


def behind_a_prism(*effects):
    """A camera of three sensors with some effects."""
    return dataclasses.replace(
        short_camera().without(Demosaic).plus(*effects), cfa=PRISM
    ).with_body(5)


@pytest.mark.parametrize("where", BACKENDS)
def test_every_pixel_is_measured_in_each_colour(where: str) -> None:
    """Each sensor has equation (1) for itself: a temporal variance of g^2 (I + r^2), a spatial one
    of g^2 f^2, and nothing in common with the next pixel nor with another sensor."""
    fpn, read = 30.0, ReadNoise(reset_e=20.0, thermal_e=0.0, other_e=0.0)
    made = camera(PhotonShot(), Fpn(sigma_e=fpn), read, **THREE)
    frames = dn(made, where)
    assert frames.shape == (LIT.frames, SIDE, SIDE, 3)
    light_e, pixels = RATE * LIT.exposure_s, SIDE * SIDE
    temporal = GAIN**2 * (light_e + 20.0**2)
    mean = frames.mean(axis=0)
    noise = frames - mean
    in_time = frames.var(axis=0, ddof=1).mean(axis=(0, 1))
    freedom = (len(frames) - 1) * pixels
    assert_agree(in_time, 3 * [temporal], 3 * [variance_error(temporal, freedom + 1)], "in time")
    left = temporal / len(frames)
    in_space = mean.var(axis=(0, 1), ddof=1) - left
    expected = GAIN**2 * fpn**2
    error = variance_error(expected + left, pixels)
    assert_agree(in_space, 3 * [expected], 3 * [error], "in space")
    power = np.square(noise).mean(axis=(0, 1, 2))
    shared = [
        (noise[..., a] * noise[..., b]).mean() / math.sqrt(power[a] * power[b])
        for a, b in ((0, 1), (1, 2), (0, 2))
    ]
    beside = (noise[:, :, 1:] * noise[:, :, :-1]).mean(axis=(0, 1, 2)) / power
    assert_agree([*shared, *beside], 6 * [0.0], 6 * [1 / math.sqrt(freedom)], "in common")


def test_the_truth_is_that_of_each_sensor() -> None:
    """The pattern that a sensor has drawn is the one in its mean image, to its temporal noise."""
    made = camera(Fpn(sigma_e=60.0), **THREE).with_body(7)
    mean = dn(made).mean(axis=0)
    protocol = Protocol(name="one", shot=(LIT,))
    table = realised(made, LIT.exposure_s, protocol, backend())
    seen = mean.std(axis=(0, 1))
    assert [table[c]["fpn"] for c in "RGB"] == pytest.approx(list(seen), rel=1e-4)
    assert len({round(float(one), 9) for one in seen}) == 3


def test_light_that_wanders_does_so_for_all_three() -> None:
    """A lamp is in front of the prism: frames of all colours are brighter together, by far more
    than their noise, of which a mean of 12,288 pixels has 0.01 DN."""
    made = behind_a_prism(LampFlicker(mains_hz=57.0))
    bright = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5).frames[-1]
    means = bright.dn.mean(axis=(1, 2))
    assert means.std(axis=0).min() > 0.3
    together = np.corrcoef(means.T)
    assert together.min() > 0.99


def test_what_was_in_a_frame_before_is_each_sensors_own() -> None:
    """Lag looks at frames that run in, and a run of frames is the same whatever is left out."""
    made, rates = behind_a_prism(ImageLag()), {"lamp": light().rate_e_per_s}
    whole = record(made, PROTOCOL, rates, seed=5).frames[-1]
    last = pixels_of(made, simulate(made, whole.shot, rates, seed=5, frames=range(9, 16)))
    np.testing.assert_array_equal(whole.dn[9:], last)


@pytest.mark.parametrize(
    ("pixels", "effects"), [("mono8", ()), ("bayer8", ()), ("rgb8", (Demosaic(),))]
)
def test_what_gives_no_three_colours_has_no_prism(pixels: Pixels, effects: tuple) -> None:
    with pytest.raises(CameraError, match="three sensors"):
        camera(*effects, cfa=PRISM, bits=8, pixels=pixels)


def test_a_camera_file_keeps_it(tmp_path) -> None:
    made = behind_a_prism()
    write(tmp_path / "camera.toml", made)
    assert load(str(tmp_path / "camera.toml")).cfa == PRISM


def taken(made) -> Capture:
    """Frames of a camera whose mosaic, if any, nobody stated."""
    capture = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)
    return dataclasses.replace(
        capture, frames=tuple(dataclasses.replace(f, cfa=None) for f in capture.frames)
    )


@pytest.mark.parametrize(
    ("made", "cfa"),
    [
        (behind_a_prism(), PRISM),
        (short_camera(), "RGGB"),
        (dataclasses.replace(short_camera(), cfa="GBRG"), "GBRG"),
        # neighbours of smoothed frames agree, with or without a mosaic: the commoner one is taken
        (short_camera().plus(SpatialDenoise(strength=1.0)), "RGGB"),
    ],
)
def test_frames_tell_whether_anything_was_filled_in(made, cfa: str) -> None:
    setting = look(taken(made), {"lamp": light()})
    assert setting is not None
    assert setting.scenery.body.cfa == cfa


def test_a_camera_of_three_sensors_is_calibrated_and_no_gap() -> None:
    """Held against a mosaic that was filled in, the same frames are G 9 off. Its gains come out as
    they went in, to five per cent: two lit shots of 12,288 pixels tell each to one per cent."""
    setting = look(taken(behind_a_prism()), {"lamp": light()})
    assert setting is not None
    known = calibrated(setting, None)
    gain = short_camera().gain_dn_per_e.G
    np.testing.assert_allclose(known.base.gain_dn_per_e, gain, rtol=0.05)
    assert camera_of(known.base, known.scenery.body).get(Demosaic) is None
    assert measured(known, setting.seen).whole.p_value > 0.01


@pytest.mark.parametrize(
    ("made", "filled"),
    [
        (behind_a_prism(), False),
        (short_camera(), True),
        (short_camera().plus(SpatialDenoise(strength=1.0)), True),
    ],
)
def test_the_technique_divides_by_no_factor_where_nothing_was_filled_in(made, filled: bool) -> None:
    """N_D of equations (4) to (7) is a demosaicer's."""
    found = irie(taken(made))
    assert (found.extra["demosaic_factors"] is not None) is filled
    assert any("bilinear demosaic was assumed" in said for said in found.warnings) is filled
    assert any("every pixel was measured" in said for said in found.warnings) is not filled


def test_one_frame_that_nobody_stated_the_colours_of_is_too_few() -> None:
    """Said in one line, without a word of the arithmetic."""
    capture = taken(behind_a_prism())
    one = tuple(
        dataclasses.replace(f, dn=f.dn[:1], shot=dataclasses.replace(f.shot, frames=1))
        for f in capture.frames
    )
    with warnings.catch_warnings(action="error"), pytest.raises(TooFewFrames):
        irie(dataclasses.replace(capture, frames=one))
