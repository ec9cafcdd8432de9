"""A camera of few figures under even light, and its frames."""

from __future__ import annotations

import dataclasses

import numpy as np

from foundation.backend import backend
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import simulate

SIDE = 96
GAIN = 0.5
LIT = Shot(label="lit", light=("lamp",), exposure_s=0.01, frames=24)
RATE = 2e5


def camera(*effects, **changes) -> Camera:
    plain = Camera(
        name="test",
        width=SIDE,
        height=SIDE,
        pixels="bayer16",
        bits=16,
        gain_dn_per_e=Colours.of(GAIN),
        black_dn=100.0,
    )
    return dataclasses.replace(plain.plus(*effects), **changes)


def rates(rate: float = RATE) -> dict[str, np.ndarray]:
    return {"lamp": np.full((SIDE, SIDE, 3), rate, np.float32)}


def dn(cam: Camera, where: str | None = None, shot: Shot = LIT, **options) -> np.ndarray:
    """Unrounded DN, (F, H, W): what the moments are told in."""
    signal = simulate(cam, shot, rates(), where=backend(where), until=Quantity.DN, **options)
    return signal.numpy().astype(np.float64)


def dark_shot() -> Shot:
    return Shot(label="dark", exposure_s=0.01, frames=24)
