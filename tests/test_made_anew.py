"""Ways that only spare time: what they give is what the plain way gives."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from foundation.backend import backend
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.effects.adc_dnl import outcomes
from sensor.effects.vibration import Vibration
from sensor.interpolation import Interpolated
from sensor.powers import power
from sensor.protocol import Shot
from sensor.sampled import Sampled
from sensor.signal import Signal
from sensor.simulation import lit, stream_of
from tests.backends import BACKENDS

WIDTHS = (32, 20, 14)
"""Runs of eight, of four and of one with a JIT backend."""
HEIGHT, FRAMES = 18, 5
SHOT = Shot(label="lit", light=("lamp",), exposure_s=0.03, frames=FRAMES)


def signal_of(shape: tuple[int, ...], where: str) -> tuple[Camera, Signal]:
    camera = load("icx098").resized(shape[1], shape[2])
    rate = {"lamp": np.ones((shape[1], shape[2], 3), dtype=np.float32)}
    values = np.random.default_rng(0).uniform(0.0, 255.0, shape).astype(np.float32)
    light = lit(camera, SHOT, rate, backend(where))
    numbers: Any = backend(where).tensor(values)
    return camera, dataclasses.replace(light, numbers=numbers, frames=range(FRAMES))


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("exponent", [-0.9, -0.3, 0.3, 0.8, 3.0])
def test_a_power_is_right_to_a_few_roundings(where: str, exponent: float) -> None:
    x = np.geomspace(2.0**-30, 2.0**10, 100_001).astype(np.float32)
    found = np.asarray(power(backend(where).tensor(x).array, exponent).numpy(), float)
    exact = x.astype(float) ** exponent
    # the rounding of the exponent of two, and that of the polynomials
    allowed = 2.0**-23 * np.abs(exponent * np.log2(x)) + 3e-7
    assert (np.abs(found / exact - 1.0) < allowed).all()


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("frames", [1, FRAMES])
def test_the_colour_that_a_pixel_sees_is_that_of_the_whole_picture(
    where: str, width: int, frames: int
) -> None:
    camera, signal = signal_of((frames, HEIGHT, width, 3), where)
    effect = Vibration(shift_px=2.0)
    stream = stream_of(camera, effect, SHOT, 1, signal.frames, signal.backend)
    moved = effect.apply(signal, stream)
    assert isinstance(moved.numbers, Sampled)
    seen = np.asarray(moved.numbers.mosaic(camera.format.cfa).tensor.numpy())
    colours = camera.format.colour_index.astype(int)[None, ..., None]
    picked = np.take_along_axis(
        moved.numpy(), np.broadcast_to(colours, (FRAMES, HEIGHT, width, 1)), 3
    )
    assert np.array_equal(seen.reshape(picked.shape), picked)


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(("arithmetic", "corners"), [(0, False), (2, False), (0, True)])
def test_colours_beside_a_pixel_are_those_of_the_picture(
    where: str, width: int, arithmetic: int, corners: bool
) -> None:
    _, mosaic = signal_of((FRAMES, HEIGHT, width), where)
    made = Interpolated(mosaic=mosaic, arithmetic=arithmetic, corners=corners)
    picture = np.pad(made.signal().numpy(), ((0, 0), (1, 1), (1, 1), (0, 0)), mode="reflect")
    rows = made.rows(1)
    length = len(rows[0][0]) - 2
    for dy in range(3):
        for colour in range(3):
            for dx in range(length + 2):
                found = np.asarray(rows[dy][colour][dx].numpy()).reshape(FRAMES, HEIGHT, -1)
                last = dx + width - length + 1
                expected = picture[:, dy : dy + HEIGHT, dx:last:length, colour]
                assert np.array_equal(found, expected), (dy, colour, dx)


def test_outcomes_are_those_of_a_converter_that_decides_bit_by_bit() -> None:
    rng = np.random.default_rng(0)
    for spread in (0.0, 0.2, 3.0):
        begins = (np.arange(64.0) + spread * rng.standard_normal(64)).astype(np.float32)
        begins[0] = 0.0
        ends, codes = outcomes(begins)
        places = np.concatenate([rng.uniform(-10.0, 80.0, 10_000).astype(np.float32), begins])
        by_bits = np.zeros(len(places), dtype=int)
        for bit in reversed(range(6)):
            trial = by_bits + (1 << bit)
            by_bits = np.where(places >= begins[trial], trial, by_bits)
        assert np.array_equal(codes[np.searchsorted(ends, places, side="right")], by_bits)
