"""A camera, its light and its protocol, as small as a diagnosis can use."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from scipy import ndimage

from render.rate import RateHeader, RateImage, rate_image
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.colours import Colours
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Protocol, Shot

HEIGHT, WIDTH = 96, 128

PROTOCOL = Protocol(
    name="short",
    shot=(
        Shot(label="dark", exposure_s=0.02, frames=16),
        Shot(label="dim", light=("lamp",), level=(0.4,), exposure_s=0.02, frames=16),
        Shot(label="bright", light=("lamp",), level=(1.0,), exposure_s=0.02, frames=16),
    ),
)


@functools.cache
def light() -> RateImage:
    """Patches with soft edges under a lamp that is brighter in the middle."""
    rng = np.random.default_rng(11)
    patches = np.kron(rng.uniform(0.1, 1.0, (6, 8, 3)), np.ones((16, 16, 1)))
    soft = ndimage.gaussian_filter(patches, (2.0, 2.0, 0))
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    shading = 1 - 0.3 * (((x - 64) / 64) ** 2 + ((y - 48) / 48) ** 2) / 2
    rate = (4.5e5 * soft * shading[..., None]).astype(np.float32)
    return rate_image(rate, np.zeros_like(rate), RateHeader(scene="patches", lamp="lamp"))


def camera() -> Camera:
    """A camera whose read noise is well above a step of its converter."""
    made = load("icx098").resized(HEIGHT, WIDTH)
    made = dataclasses.replace(made, gain_dn_per_e=Colours.of(0.02), black_dn=6.0)
    return made.plus(ReadNoise(reset_e=0.0, thermal_e=30.0, other_e=0.0))
