"""EMVA 1288 on a camera that is what the standard supposes, and where the standard says no."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.estimators.emva1288 import emva1288
from analysis.estimators.parts.high_pass import KERNEL, smoothing, spatial_variance
from analysis.parameters import CannotTell
from sensor.frames import Capture, Frames, Panel, Shot, TooFewFrames

LIMIT = 4.5
"""Standard errors: 7e-6 two-sided, below 0.001 over the comparisons of this file."""

GAIN, READ_E, DSNU_DN, PRNU, BLACK_DN = 0.05, 30.0, 0.8, 0.01, 20.0
SIDE, PANELS = 50, 4
TOP_DN = 255


def poisson_camera(
    seed, *, frames=60, prnu=PRNU, read_e=READ_E, ramp=0.0, dark_e_per_s=0.0, pixels="mono8"
) -> Capture:
    """Darks at two exposures and light at three levels, half of saturation the highest."""
    generator = np.random.default_rng(seed)
    shape = (SIDE, SIDE * PANELS)
    offset = generator.normal(0, DSNU_DN, shape)
    response = 1 + generator.normal(0, prnu, shape)
    slope = 1 + ramp * np.linspace(-0.5, 0.5, SIDE)[:, None]
    stacks = []
    for label, level, exposure in (
        ("dark-1", 0.0, 0.5),
        ("dark-2", 0.0, 1.0),
        ("lamp-1", 0.25, 1.0),
        ("lamp-2", 0.5, 1.0),
        ("lamp-3", 1.0, 1.0),
    ):
        electrons = level * 2200.0 * slope * response + dark_e_per_s * exposure
        signal = generator.poisson(electrons, (frames, *shape))
        signal = signal + generator.normal(0, read_e, (frames, *shape))
        # The dark current's mean is clamped away, as cameras do; its noise stays.
        dn = np.rint(BLACK_DN + offset + GAIN * (signal - dark_e_per_s * exposure))
        dn = np.clip(dn, 0, TOP_DN).astype(np.uint8)
        light = ("lamp",) if level else ("none",)
        shot = Shot(label=label, light=light, exposure_s=exposure, frames=frames)
        stacks.append(Frames(dn=dn, shot=shot, pixels=pixels, bits=8))
    panels = tuple(Panel(name=str(k), x=k * SIDE, y=0, w=SIDE, h=SIDE) for k in range(PANELS))
    return Capture(camera="x", frames=tuple(stacks), panels=panels)


@pytest.fixture(scope="module")
def found():
    return emva1288(poisson_camera(1)).channels["Y"]


@pytest.mark.parametrize(
    ("key", "truth"),
    [("gain", GAIN), ("read", GAIN * READ_E), ("dsnu", DSNU_DN), ("prnu", PRNU)],
)
def test_the_standards_own_camera_is_recovered(found, key, truth):
    assert abs(found[key].value - truth) < LIMIT * found[key].se
    assert found[key].se < 0.1 * truth


def test_stated_errors_are_the_scatter_over_bodies_and_frames():
    count = 80
    runs = [emva1288(poisson_camera([20, k], frames=20)).channels["Y"] for k in range(count)]
    for key in ("gain", "read", "dsnu", "prnu"):
        scatter = np.std([run[key].value for run in runs], ddof=1)
        stated = np.sqrt(np.mean([run[key].se ** 2 for run in runs]))
        # Misfit factors are 1 or more, and two darks of one panel count as one: a tenth too wide.
        spread = LIMIT / np.sqrt(2 * count)
        assert 1 - spread < stated / scatter < 1.1 + spread, key


def test_a_lighting_ramp_is_not_read_as_prnu():
    capture = poisson_camera(2, ramp=0.05)
    prnu = emva1288(capture).channels["Y"]["prnu"]
    assert abs(prnu.value - PRNU) < LIMIT * prnu.se
    lit = capture.frames[-1].dn[:, :, :SIDE].mean(axis=0) - BLACK_DN
    assert lit.std() / lit.mean() > 1.4 * PRNU  # what the ramp does without the high-pass


def test_no_prnu_is_not_reported_as_some():
    told = emva1288(poisson_camera(3, prnu=0.0)).channels["Y"]["prnu"]
    assert isinstance(told, CannotTell)
    assert "below" in told.reason


def test_dark_current_shows_in_the_variance_alone():
    found = emva1288(poisson_camera(4, dark_e_per_s=900.0)).channels["Y"]
    assert abs(found["dark_shot"].value - GAIN * 30.0) < LIMIT * found["dark_shot"].se
    assert abs(found["read"].value - GAIN * READ_E) < LIMIT * found["read"].se
    assert isinstance(emva1288(poisson_camera(1)).channels["Y"]["dark_shot"], CannotTell)


def test_dark_noise_below_the_standards_limit_is_not_told():
    found = emva1288(poisson_camera(5, read_e=6.0)).channels["Y"]
    assert "below 0.24" in found["read"].reason
    assert abs(found["gain"].value - GAIN) < 0.02 * GAIN


def test_one_difference_of_two_frames_is_enough():
    found = emva1288(poisson_camera(6, frames=2)).channels["Y"]
    assert abs(found["gain"].value - GAIN) < LIMIT * found["gain"].se


def test_without_darks_or_light_it_says_so():
    capture = poisson_camera(7, frames=4)
    lit = emva1288(replace(capture, frames=capture.lit)).channels["Y"]
    assert all('light = "none"' in finding.reason for finding in lit.values())
    dark = emva1288(replace(capture, frames=capture.darks)).channels["Y"]
    assert "lit" in dark["gain"].reason
    assert dark["read"].value > 0
    one = replace(capture.frames[0], dn=capture.frames[0].dn[:1])
    with pytest.raises(TooFewFrames):
        emva1288(replace(capture, frames=(one,)))


@pytest.mark.parametrize(("cfa", "warned"), [("RGGB", True), (None, False)])
def test_demosaiced_frames_are_warned_of(cfa, warned):
    """A mosaic is stated; of frames without one the noise shows that every pixel was measured."""
    capture = poisson_camera(8, frames=4)
    colour = tuple(
        Frames(
            dn=np.repeat(f.dn[..., None], 3, axis=3), shot=f.shot, pixels="rgb8", bits=8, cfa=cfa
        )
        for f in capture.frames
    )
    found = emva1288(replace(capture, frames=colour)).warnings
    assert any("raw frames" in text for text in found) is warned


def test_the_smoothing_passes_ramps_and_the_high_pass_stops_them():
    assert KERNEL.sum() == pytest.approx(1)
    assert len(KERNEL) == 7 + 11 + 3 - 2
    t = np.arange(40.0)
    assert np.allclose(smoothing(40) @ t, t)
    ramp = 100 + 3 * t[:, None] - 2 * np.arange(30.0)[None, :]
    assert spatial_variance(ramp)[0] < 1e-20


@pytest.mark.parametrize("shape", [(50, 50), (25, 25), (12, 40)])
def test_white_noise_keeps_its_variance_through_the_high_pass(shape):
    generator = np.random.default_rng(9)
    found = [spatial_variance(generator.normal(0, 2, shape)) for _ in range(300)]
    values = np.array([value for value, _ in found])
    assert abs(values.mean() - 4) < LIMIT * values.std(ddof=1) / 300**0.5
    stated = np.sqrt(np.mean([se**2 for _, se in found]))
    assert stated == pytest.approx(values.std(ddof=1), rel=LIMIT / (2 * 300) ** 0.5 + 0.05)
