"""Long shots in batches, and effects that look at other frames of a batch."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from foundation.backend import backend
from sensor import record
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.catalogue import effect
from sensor.effects.image_lag import ImageLag
from sensor.film import Film
from sensor.protocol import Shot
from sensor.signal import Signal
from sensor.simulation import lit, pixels_of, simulate, still
from tests.backends import BACKENDS

FRAMES = 11
SHOT = Shot(label="lit", light=("lamp",), exposure_s=0.03, frames=FRAMES)


def camera_with(height: int, width: int, *names: str) -> Camera:
    effects = [effect(name).with_parameters({}) for name in names]
    return load("icx098").resized(height, width).plus(*effects)


def rates(camera: Camera) -> dict[str, Any]:
    ramp = np.linspace(10.0, 3e5, camera.width * 3).reshape(1, camera.width, 3)
    return {"lamp": np.broadcast_to(ramp, (camera.height, camera.width, 3)).astype(np.float32)}


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("width", [16, 12, 10])
@pytest.mark.parametrize(
    ("names", "chance"),
    [
        ((), 0.0),
        (("lamp_drift",), 0.0),
        (("image_lag",), 0.0),
        (("image_lag",), 1.0),
        (("temporal_filter", "dropped_frames"), 0.0),
    ],
)
def test_batches_make_the_frames_of_the_whole_shot(
    where: str,
    width: int,
    names: tuple[str, ...],
    chance: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    camera = camera_with(6, width, *names)
    if "image_lag" in names:
        camera = camera.plus(ImageLag(fraction=0.1, by_chance=chance, from_dark=chance))
    monkeypatch.setattr(record, "BATCH_PIXELS", 3 * 6 * width)
    batches = list(record.take(camera, SHOT, rates(camera), where=backend(where)))
    assert [len(batch) for batch in batches] == [3, 3, 3, 2]
    whole = pixels_of(camera, simulate(camera, SHOT, rates(camera), where=backend(where)))
    assert np.array_equal(np.concatenate(batches), whole)


@pytest.mark.parametrize("where", [name for name in BACKENDS if backend(name).jit])
def test_what_frames_share_ends_where_they_begin_to_differ(where: str) -> None:
    for names, done in (((), "photon_shot"), (("lamp_drift",), "lamp_drift")):
        camera = camera_with(6, 16, *names)
        light = lit(camera, SHOT, rates(camera), backend(where))
        shared, count = still(camera, light, seed=0)
        assert camera.effects[count].name == done
        assert shared.shape[0] == 1
        assert shared.least == pytest.approx(shared.numpy().min())


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("width", [16, 12, 10])
@pytest.mark.parametrize("step", [1, 3, 20])
@pytest.mark.parametrize("coloured", [False, True])
def test_a_filter_in_time_is_its_sum(where: str, width: int, step: int, coloured: bool) -> None:
    camera = camera_with(6, width)
    light = lit(camera, SHOT, rates(camera), backend(where))
    shape = (FRAMES, 6, width, 3) if coloured else (FRAMES, 6, width)
    values = np.random.default_rng(0).uniform(0.0, 255.0, shape).astype(np.float32)
    signal: Signal = dataclasses.replace(light, numbers=backend(where).tensor(values))
    weights = [0.5, 0.25, 0.125, 0.125]
    filtered = signal.replace(Film.of(signal).filtered(weights, step)).numpy()
    for k in range(FRAMES):
        seen = [k - d * step if k >= d * step else k % step for d in range(4)]
        expected = sum(w * values[j].astype(float) for w, j in zip(weights, seen, strict=True))
        if k >= 3 * step or where != "scalar":
            assert np.allclose(filtered[k], expected, rtol=0, atol=4 * 255 * 2.0**-24)
