"""The camera by somebody else: its faults have names of the catalogue, and each shows in frames."""

from __future__ import annotations

import numpy as np
import pytest

from docs.examples import another_camera
from docs.examples.another_camera import FAULTS, HEIGHT, LIT_S, WIDTH, Camera, photograph
from sensor.catalogue import catalogue


def frames(fault: str) -> np.ndarray:
    """A shot of a bright bar on a ramp; the same random numbers for every fault."""
    light = np.ones((HEIGHT, WIDTH, 3)) * np.linspace(200, 3000, WIDTH)[:, None]
    light[40:80, 60:100] += 4000
    camera = Camera(k=1.0, draw=np.random.default_rng(3))
    return photograph(camera, light, LIT_S, fault)


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(another_camera, "FRAMES", 4)


@pytest.mark.usefixtures("few")
def test_noise_of_the_camera_is_what_its_figures_say() -> None:
    """Of 4 frames: variance is read noise and shot noise in DN, of measured green samples, within
    4.5 standard errors and a twelfth of a DN^2 for rounding."""
    draw = np.random.default_rng(3)
    camera = Camera(k=1.0, draw=draw)
    mean_e = 1500.0
    dn = photograph(camera, np.full((HEIGHT, WIDTH, 3), mean_e), 0.0, "none")
    green = dn[:, 0::2, 1::2, 1].astype(float)
    gain = camera.gain_dn_per_e[0, 1]
    expected = gain**2 * (mean_e + camera.read_e**2) + 1 / 12
    error = 4.5 * np.sqrt(2 / (green.size * 3 / 4))
    assert green.var(axis=0, ddof=1).mean() == pytest.approx(expected, rel=error)


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_the_catalogue_changes_frames(fault: str) -> None:
    assert fault in catalogue()
    harmed, fine = frames(fault), frames("none")
    assert harmed.shape == fine.shape == (4, HEIGHT, WIDTH, 3)
    if fault != "dropped_frames":  # one in ten is lost, of four perhaps none
        assert (harmed != fine).mean() > 1e-3
