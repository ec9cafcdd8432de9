"""A bench for single effects: a camera whose codes are electrons, and light to point it at.

One DN is one electron, so that rounding adds 1/12 e-^2 and nothing else, and black stands high
enough that nothing is clipped there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foundation.backend import backend
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Shot
from sensor.simulation import pixels_of, simulate

EXPOSURE_S = 0.03268
INTERVAL_S = 1 / 15
BLACK_E = 500.0
READ_E = 5.0

Array = NDArray[np.float64]


def flat(electrons: float, height: int = 64, width: int = 96) -> NDArray[np.float32]:
    """The rate image of an even grey: so many electrons in `EXPOSURE_S`, (H, W, 3)."""
    return rate_of(np.full((height, width), electrons))


def rate_of(electrons: ArrayLike) -> NDArray[np.float32]:
    """The rate image that gives these electrons in `EXPOSURE_S`: (H, W) grey, or (H, W, 3)."""
    rate = np.asarray(electrons, float) / EXPOSURE_S
    return (np.stack([rate] * 3, -1) if rate.ndim == 2 else rate).astype(np.float32)


def bench_camera(
    *effects: Effect, height: int, width: int, cfa: str = "GGGG", body_seed: int = 0
) -> Camera:
    """Photon shot noise, read noise of `READ_E`, a converter of 16 bits, and these effects."""
    base = (
        PhotonShot(),
        ReadNoise(reset_e=0.0, thermal_e=READ_E, other_e=0.0),
        Quantization(),
    )
    camera = Camera(
        name="bench",
        height=height,
        width=width,
        pixels="bayer16",
        bits=16,
        cfa=cfa,
        gain_dn_per_e=Colours.of(1.0),
        black_dn=BLACK_E,
        effects=base,
        body_seed=body_seed,
    )
    return camera.plus(*effects)


def frames_of(
    *effects: Effect,
    rate: NDArray[np.float32],
    frames: int = 16,
    level: float = 1.0,
    exposure_s: float = EXPOSURE_S,
    interval_s: float | None = INTERVAL_S,
    temperature_c: float | None = None,
    label: str = "bench",
    cfa: str = "GGGG",
    seed: int = 1,
    body_seed: int = 0,
    where: str | None = None,
) -> Array:
    """Frames of the bench camera in electrons above black: (F, H, W). Level 0 is a dark shot."""
    shot = Shot(
        label=label,
        light=("lamp",),
        level=(level,),
        exposure_s=exposure_s,
        frames=frames,
        interval_s=interval_s,
        temperature_c=temperature_c,
    )
    camera = bench_camera(
        *effects, height=rate.shape[0], width=rate.shape[1], cfa=cfa, body_seed=body_seed
    )
    signal: Any = simulate(camera, shot, {"lamp": rate}, seed=seed, where=backend(where))
    return pixels_of(camera, signal).astype(np.float64) - BLACK_E


def mean_and_error(frames: Array) -> tuple[Array, Array]:
    """Mean over frames of every pixel and its standard error, from the pixel's own variance."""
    return frames.mean(0), np.sqrt(frames.var(0, ddof=1) / len(frames))
