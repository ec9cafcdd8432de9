"""Presets: what each says of itself is what its frames show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sensor.camera_file import load, preset_names
from sensor.colours import Colours
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate
from tests.harness import assert_agree, variance_error

SIDE, FRAMES, EXPOSURE_S = 96, 24, 0.01


def test_the_presets_are_these() -> None:
    assert set(preset_names()) >= {"i400", "i400-debiased", "icx098", "icx655", "ideal"}


@pytest.mark.parametrize("name", preset_names())
@pytest.mark.parametrize("electrons", [500.0, 4000.0])
def test_mean_and_noise_of_every_mosaic_are_those_the_preset_states(
    name: str, electrons: float
) -> None:
    """Before the demosaicer, in DN: g I + b, and temporal variance g^2 (I + dark + read^2)."""
    camera = load(name).resized(SIDE, SIDE)
    rate = np.empty((SIDE, SIDE, 3), np.float32)
    for k, of_colour in enumerate(camera.sensitivity):
        rate[..., k] = electrons / EXPOSURE_S / of_colour
    shot = Shot(label="lit", light=("lamp",), exposure_s=EXPOSURE_S, frames=FRAMES)
    kept = tuple(e for e in camera.effects if e.name not in ("demosaic", "quantization", "fpn"))
    plain = camera.without(*(type(e) for e in camera.effects if e not in kept))
    frames = simulate(plain, shot, {"lamp": rate}, until=Quantity.DN).numpy().astype(float)
    read, prnu, clamp = camera.get(ReadNoise), camera.get(Prnu), camera.get(BlackLevelOffset)
    dark_e = next((e.current_e_per_s for e in kept if e.name == "dark_shot"), 0.0) * EXPOSURE_S
    sites = camera.resized(SIDE, SIDE).format.colour_index
    for k, channel in enumerate("RGB"):
        at = frames[:, sites == k]
        gain = camera.gain_dn_per_e[channel]
        sigma_e = read.sigma_e[channel] if read else 0.0
        offset_e = Colours.of(clamp.offset_e)[channel] if clamp else 0.0
        variance = gain**2 * (electrons + dark_e + sigma_e**2)
        # the preset's hot pixels add a few e- at most
        pattern = gain * electrons * (Colours.of(prnu.ratio)[channel] if prnu else 0.0)
        mean_error = math.sqrt(variance / at.size + pattern**2 / at.shape[1])
        assert_agree(
            [at.mean(), at.var(0, ddof=1).mean()],
            [gain * (electrons + offset_e) + camera.black_dn, variance],
            [mean_error, variance_error(variance, (FRAMES - 1) * at.shape[1])],
            f"{name} {channel}",
        )


def test_the_camera_of_real_frames_has_dark_frames_like_them() -> None:
    """99.8 % of the pixels at 0, none above 2 DN but the hot ones, as the published frames."""
    camera = load("icx655").resized(344, 408)
    shot = Shot(label="dark", exposure_s=0.025, frames=4)
    dark = pixels_of(camera, simulate(camera, shot, {}))
    assert 0.9975 < (dark == 0).mean() < 1.0
    assert (dark > 2).mean() < 1e-4
