"""What the tests of effects from readout to cable share: an effect alone, and its impostor."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from foundation.backend import backend
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Shot
from sensor.signal import Format, Signal
from sensor.simulation import stream_of
from tests.effects_bench import READ_E, Array
from tests.harness import assert_agree, worst_z

LIGHT_E = 400.0
NOISE = LIGHT_E + READ_E**2
"""Temporal variance of the bench in e-^2 at LIGHT_E, before rounding."""

ROUNDING = 1 / 12

Figures = tuple[Any, Any, Any]
"""Measured, expected, standard errors."""


def tells_apart(figures: Callable[[Array], Figures], real: Array, impostor: Array) -> None:
    """The effect has its closed form; its impostor has not."""
    assert_agree(*figures(real), "the effect")
    worst, limit = worst_z(*figures(impostor))
    assert worst > limit, f"the impostor passes: {worst:.2f} standard errors of {limit:.2f}"


def by_frame(statistics: Array) -> tuple[Array, Array]:
    """Mean of figures taken frame by frame, (F, n), and its standard error."""
    error = statistics.std(0, ddof=1) / math.sqrt(len(statistics))
    return statistics.mean(0), error


def independent(sigma: float) -> ReadNoise:
    """Independent noise of that standard deviation on top of the bench's own."""
    return ReadNoise(reset_e=0.0, thermal_e=READ_E, other_e=sigma)


def applied(
    effect: Effect, values: Array, *, cfa: str = "GGGG", bits: int = 8, black_dn: float = 0.0
) -> Array:
    """The effect alone on given DN, frame by frame."""
    camera = Camera(
        name="bare", height=values.shape[1], width=values.shape[2], pixels="bayer16", bits=16,
        gain_dn_per_e=Colours.of(1.0),
    )  # fmt: skip
    shot = Shot(label="bare", exposure_s=0.01, frames=len(values))
    where, frames = backend(), range(len(values))
    form = Format(
        height=values.shape[1], width=values.shape[2], cfa=cfa, bits=bits,
        gain_dn_per_e=camera.gain_dn_per_e, black_dn=black_dn,
    )  # fmt: skip
    signal = Signal(
        numbers=where.tensor(values), quantity=effect.quantity(), format=form, shot=shot,
        frames=frames, backend=where,
    )  # fmt: skip
    stream = stream_of(camera, effect, shot, 1, frames, where)
    return effect.apply(signal, stream).numpy().astype(np.float64)


def noise_on(level: float, sigma: float, *shape: int, seed: int = 5) -> Array:
    return level + sigma * np.random.default_rng(seed).standard_normal(shape)


def covariances(frames: Array, mean: float, lags: list[tuple[int, int]]) -> Array:
    """Covariance at lags (dy, dx) of every frame about a known mean, (F, lags); no borders."""
    d = frames[:, 3:-3, 3:-3] - mean
    height, width = d.shape[1:]
    return np.stack(
        [
            (d[:, : height - dy, : width - dx] * d[:, dy:, dx:]).mean((1, 2))
            for dy, dx in lags
        ],
        axis=1,
    )  # fmt: skip
