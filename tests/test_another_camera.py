"""Cameras by somebody else: their faults have names of the catalogue, and each shows in frames."""

from __future__ import annotations

import numpy as np
import pytest

from docs.examples.another_body import GREY, HEIGHT, WIDTH, Camera
from docs.examples.another_camera import KINDS, LIT_S, photograph
from sensor.catalogue import catalogue


def camera(pixels: str = "rgb8") -> Camera:
    """The same body, whatever it sends."""
    return Camera(
        k=1.0,
        draw=np.random.default_rng(3),
        cfa=GREY if pixels == "mono16" else "RGGB",
        bits=8 if pixels == "rgb8" else 12,
        frames=4,
    )


def frames(fault: str, pixels: str) -> np.ndarray:
    """A shot of a bright bar on a ramp; the same random numbers for every fault."""
    light = np.ones((HEIGHT, WIDTH, 3)) * np.linspace(200, 3000, WIDTH)[:, None]
    light[40:80, 60:100] += 4000
    return photograph(camera(pixels), light, LIT_S, fault, pixels)


@pytest.mark.parametrize("pixels", KINDS)
def test_noise_of_the_camera_is_what_its_figures_say(pixels: str) -> None:
    """Of 4 frames: variance is read noise and shot noise in DN, of measured green samples, within
    4.5 standard errors and a twelfth of a DN^2 for rounding."""
    body = camera(pixels)
    mean_e = 1500.0
    dn = photograph(body, np.full((HEIGHT, WIDTH, 3), mean_e), 0.0, "none", pixels)
    plane = dn[..., 1] if pixels == "rgb8" else dn
    green = plane[:, 0::2, 1::2].astype(float)
    gain = body.gain_dn_per_e[0, 1]
    expected = gain**2 * (mean_e + body.read_e**2) + 1 / 12
    error = 4.5 * np.sqrt(2 / (green.size * 3 / 4))
    assert green.var(axis=0, ddof=1).mean() == pytest.approx(expected, rel=error)


@pytest.mark.parametrize(
    ("pixels", "fault"), [(pixels, fault) for pixels in KINDS for fault in KINDS[pixels]]
)
def test_a_fault_of_the_catalogue_changes_frames(pixels: str, fault: str) -> None:
    assert fault in catalogue()
    harmed, fine = frames(fault, pixels), frames("none", pixels)
    colours = (3,) if pixels == "rgb8" else ()
    assert harmed.shape == fine.shape == (4, HEIGHT, WIDTH, *colours)
    if fault != "dropped_frames":  # one in ten is lost, of four perhaps none
        assert (harmed != fine).mean() > 1e-3
