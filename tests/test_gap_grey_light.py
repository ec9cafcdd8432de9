"""What a camera without colour filters sees of light that is stated in three colours."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.camera.grey_light import GREEN, USUAL, Picture, Sum, sum_seen
from analysis.gap.camera.light import light_of
from sensor.frames import Capture, Frames, Pixels
from sensor.protocol import Shot
from tests.short import light

HEIGHT, WIDTH = 80, 120


def patches(seed: int) -> np.ndarray:
    """Light of 24 patches of any colour, (H, W, 3)."""
    colours = np.random.default_rng(seed).uniform(0.1, 1.0, (4, 6, 3))
    return np.kron(colours, np.ones((HEIGHT // 4, WIDTH // 6, 1))).astype(np.float32)


def seen_as(weights: tuple[float, float, float]) -> list[Picture]:
    """Pictures of both lamps, each as bright as it is, and with a hundredth of noise."""
    rng = np.random.default_rng(3)
    pictures = []
    for seed, bright in ((1, 40.0), (2, 150.0)):
        rate = patches(seed).reshape(-1, 3)
        seen = bright * rate @ np.asarray(weights)
        pictures.append(Picture(seen=seen * rng.normal(1.0, 0.01, len(seen)), rate=rate))
    return pictures


@pytest.mark.parametrize("usual", USUAL, ids=lambda usual: usual.name)
def test_the_sum_that_a_grey_camera_sees_is_told_by_its_pictures(usual: Sum) -> None:
    assert sum_seen(seen_as(usual.weights)) == usual


@pytest.mark.parametrize("weights", [(0.33, 0.49, 0.18), (0.6, 0.4, 0.0), (0.1, 0.2, 0.7)])
def test_a_sum_of_its_own_is_told_as_well(weights: tuple[float, float, float]) -> None:
    """The chart has 24 colours, and each patch of 400 pixels a standard error of 5e-4 of itself. A
    weight is known to about 5e-4 / sqrt(2 x 24) of the sum over the spread of one colour, 0.26 of a
    mean of 0.55: 1.5e-4. No more than 1e-3 off is 6 standard errors, for nine weights."""
    found = sum_seen(seen_as(weights))
    assert found.name.startswith(f"{weights[0]:.2f} of red")
    assert found.weights == pytest.approx(weights, abs=1e-3)


@pytest.mark.parametrize("leakage", [0.02, 0.1])
def test_an_error_of_the_spectral_response_is_no_other_sum(leakage: float) -> None:
    """A share of red's and blue's light in green's is a suspect, and green is what it is held
    against; a third is all three together."""
    rate = patches(4).reshape(-1, 3)
    mixed = rate @ np.array([leakage, 1 - 2 * leakage, leakage])
    assert sum_seen([Picture(seen=mixed, rate=rate)]) == GREEN
    third = rate @ np.full(3, 1 / 3)
    assert sum_seen([Picture(seen=third, rate=rate)]) == USUAL[1]


def test_without_a_picture_it_is_green() -> None:
    assert sum_seen([]) == GREEN
    assert sum_seen([Picture(seen=np.ones(5), rate=np.ones((5, 3)))]) == GREEN


@pytest.mark.parametrize(("pixels", "together"), [("mono16", True), ("rgb8", False)])
def test_light_of_a_grey_camera_is_all_that_falls_on_it(pixels: Pixels, together: bool) -> None:
    """In the light that twins are lit by green is that sum; a colour camera's stays as stated."""
    rate = patches(5)
    summed = rate.sum(axis=2)
    dn = np.round(100.0 + 30.0 * (summed if together else rate.transpose(2, 0, 1)))
    stack = np.stack([dn if together else dn.transpose(1, 2, 0)] * 3)
    shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=0.01, frames=3)
    frames = Frames(
        dn=stack.astype(np.uint16 if together else np.uint8),
        shot=shot,
        pixels=pixels,
        bits=12 if together else 8,
        cfa=None if together else "RGGB",
    )
    stated = dataclasses.replace(light(), rate_e_per_s=rate)
    found = light_of(Capture(camera="theirs", frames=(frames,)), {"lamp": stated}, black_dn=100.0)
    green = summed if together else rate[..., 1]
    np.testing.assert_allclose(found.rates["lamp"][..., 1], green, rtol=1e-6)
    assert found.source.endswith("together") is together
