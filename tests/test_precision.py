"""Float32 is enough: the base chain against the same chain in NumPy's float64, number by number.

Both see the same standard normal numbers; all that differs is the arithmetic, and the Poisson
count, which the reference takes from SciPy's quantile where the mean is small.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage, stats

from foundation.backend import backend
from sensor.camera import Camera
from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect
from sensor.effects.dark_shot import DarkShot
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.prnu import Prnu
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.poisson import SMALL_MEAN
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate, stream_of
from tests.backends import BACKENDS

HEIGHT, WIDTH, FRAMES = 96, 128, 12
EXPOSURE_S = 0.03268
BIAS_DN = 1e-3
ROUNDING = 2.0**-24
"""Of a float32, relative: 1.5e-5 DN at 255 DN, and more than 1e-3 DN at the top of 16 bits."""


Array = NDArray[np.float64]

CAMERAS = {
    # 66 e-/DN to 255 DN, as a 1/4 inch sensor; and 0.6 e-/DN to 65535 DN
    "8 bits": {"bits": 8, "pixels": "rgb8", "gain": Colours(R=0.016, G=0.01515, B=0.02)},
    "16 bits": {"bits": 16, "pixels": "bayer16", "gain": Colours(R=1.7, G=1.6, B=1.8)},
}
FULL_E = {"8 bits": 15_000.0, "16 bits": 35_000.0}


def camera_of(name: str) -> Camera:
    figures = CAMERAS[name]
    effects: tuple[Effect, ...] = (
        Prnu(ratio=0.02),
        DarkShot(current_e_per_s=60.0),
        PhotonShot(),
        Fpn(sigma_e=Colours(R=12.0, G=10.0, B=12.0)),
        ReadNoise(thermal_e=Colours(R=14.0, G=13.0, B=14.0)),
    )
    last = (Demosaic(), Quantization()) if figures["pixels"] == "rgb8" else (Quantization(),)
    return Camera(
        name=name,
        height=HEIGHT,
        width=WIDTH,
        bits=figures["bits"],
        pixels=figures["pixels"],
        gain_dn_per_e=figures["gain"],
        black_dn=3.0,
        effects=(*effects, *last),
        body_seed=5,
    )


def ramp(full_e: float) -> NDArray[np.float32]:
    """From no light at all to the full well, evenly in the logarithm and then evenly."""
    few = np.concatenate([[0.0], np.geomspace(0.01, full_e, WIDTH // 2 - 1)])
    across = np.concatenate([few, np.linspace(0.0, full_e, WIDTH // 2)])
    rate = np.broadcast_to(across / EXPOSURE_S, (HEIGHT, WIDTH))
    return (rate[..., None] * np.array([0.8, 1.0, 0.9])).astype(np.float32)


def numbers(camera: Camera, kind: type[Effect], shot: Shot, where: str, body: bool) -> Array:
    effect = camera.get(kind)
    assert effect
    stream = stream_of(camera, effect, shot, 3, range(FRAMES), backend(where))
    drawn = (stream.body if body else stream).normal(HEIGHT, WIDTH)
    return np.asarray(drawn.numpy(), float).reshape(drawn.shape)


def counted(mean: Array, w: Array) -> Array:
    """Poisson quantiles at the probability of w: SciPy's, and Giles' expansion for large means."""
    m = np.maximum(mean, SMALL_MEAN)
    root = np.sqrt(m)
    large = m + w * root + 1 / 3 + w**2 / 6 - (w / 36 + w**3 / 72) / root
    large += (-8 / 405 + 7 * w**2 / 810 + w**4 / 270) / m
    small = stats.poisson.ppf(stats.norm.cdf(w), np.minimum(mean, SMALL_MEAN))
    return np.where(mean < SMALL_MEAN, small, np.floor(large))


def bilinear(mosaic: Array, colours: NDArray[np.uint8]) -> Array:
    """The mean of the nearest samples of a colour, by convolution."""
    kernel = np.outer([1, 2, 1], [1, 2, 1]) / 4.0
    planes = []
    for colour in range(3):
        there = (colours == colour).astype(float)
        known = ndimage.convolve(there, kernel, mode="mirror")
        filled = [ndimage.convolve(frame * there, kernel, mode="mirror") for frame in mosaic]
        planes.append(np.where(there == 1.0, mosaic, np.array(filled) / known))
    return np.stack(planes, -1)


def reference(camera: Camera, shot: Shot, rate: Array, where: str) -> Array:
    """Unrounded DN of all frames in float64."""
    colours = camera.format.colour_index
    gain, fpn, read, prnu, dark = (
        camera.gain_dn_per_e,
        camera.get(Fpn),
        camera.get(ReadNoise),
        camera.get(Prnu),
        camera.get(DarkShot),
    )
    assert fpn
    assert read
    assert prnu
    assert dark

    def of_pixel(figures: Colours) -> Array:
        return np.array([figures[name] for name in CHANNELS])[colours]

    dark_e = dark.current_e_per_s * EXPOSURE_S
    light = np.take_along_axis(rate, colours[..., None].astype(int), 2)[..., 0] * EXPOSURE_S
    mean = light * (1 + prnu.ratio * numbers(camera, Prnu, shot, where, True)) + dark_e
    if backend(where).jit:
        normal = numbers(camera, PhotonShot, shot, where, False)
        charge = counted(np.broadcast_to(mean, normal.shape), normal)
    else:
        # NumPy's own Poisson numbers, in float64; those of a mean that is off by a rounding are
        # others altogether, so they are drawn for the chain's own mean once that is found right
        own = _mean_of_the_chain(camera, shot, rate, where)
        assert abs((own - mean).mean()) * max(gain) < BIAS_DN
        stream = stream_of(camera, PhotonShot(), shot, 3, range(FRAMES), backend(where))
        charge = np.stack([stream._generator(k, "").poisson(own[0]) for k in range(FRAMES)])
    charge = charge + of_pixel(Colours.of(fpn.sigma_e)) * numbers(camera, Fpn, shot, where, True)
    charge = charge + of_pixel(read.sigma_e) * numbers(camera, ReadNoise, shot, where, False)
    dn = (charge - dark_e) * of_pixel(gain) + camera.black_dn
    return bilinear(dn, colours) if camera.get(Demosaic) else dn


def _mean_of_the_chain(camera: Camera, shot: Shot, rate: Array, where: str) -> Array:
    before = camera.without(PhotonShot, Fpn, ReadNoise, Demosaic, Quantization)
    light = {"lamp": rate.astype(np.float32)}
    signal = simulate(before, shot, light, seed=3, until=Quantity.ELECTRONS, where=backend(where))
    return signal.numpy()[:1].astype(float)


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("name", CAMERAS)
def test_float32_brings_no_bias(name: str, where: str) -> None:
    camera, rate = camera_of(name), ramp(FULL_E[name])
    shot = Shot(label="lit", light=("lamp",), exposure_s=EXPOSURE_S, frames=FRAMES)
    light = {"lamp": rate}
    options = {"seed": 3, "where": backend(where)}
    exact = reference(camera, shot, rate.astype(float), where)
    before = camera.without(Quantization)
    unrounded = simulate(before, shot, light, **options, until=Quantity.DN).numpy().astype(float)
    codes = pixels_of(camera, simulate(camera, shot, light, **options)).astype(float)
    rounded = np.clip(np.rint(exact), 0, camera.format.top_dn)
    # a float32 count rounds up to a whole electron from half a spacing below it, hence twice
    for found, expected in ((unrounded, exact), (codes, rounded)):
        assert abs((found - expected).mean()) < max(BIAS_DN, 2 * exact.mean() * ROUNDING)
    if camera.bits == 8:  # at each level by itself
        assert np.abs((unrounded - exact).mean(axis=(0, 1))).max() < BIAS_DN
