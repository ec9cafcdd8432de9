"""Closed forms of the bias: exact moments of rounding, factors of the demosaic, the technique."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.bias.demosaic import detrended_variance, site_factors
from analysis.bias.domain import figures, foretold, true_figures, warning
from analysis.bias.prediction import Make, Seen, predict
from analysis.bias.rounding import (
    before_rounding_dn2,
    on_average_dn2,
    rounded,
    sample_sd_factor,
)
from analysis.bias.technique import PRINTED, REPAIRED, parameters
from analysis.bias.two_noises import two_noises
from analysis.estimators.parts.panel_noise import combine, measure_panel
from analysis.parameters import Estimate, NoiseParameters, Point
from foundation.panel import Panel
from sensor.frames import Capture, Frames, Shot
from tests.harness import assert_agree

DRAWS = 400_000


@pytest.mark.parametrize("sd", [0.02, 0.1, 0.4, 1.0])
def test_noise_behind_rounding_is_that_of_levels_anywhere_on_average(sd):
    """The mean of the exact variances over a grid of levels, which is exact for a periodic function
    with fewer waves than it has points; of little noise s / sqrt(pi), of much s^2 + 1/12."""
    levels = 20.0 + (np.arange(512) + 0.5) / 512
    exact = float(np.square(rounded(levels, sd).sd_dn).mean())
    assert float(on_average_dn2(sd**2)) == pytest.approx(exact, rel=1e-5)
    assert float(before_rounding_dn2(exact)) == pytest.approx(sd**2, rel=1e-3)
    limit = sd / math.sqrt(math.pi) if sd < 0.3 else sd**2 + 1 / 12
    assert exact == pytest.approx(limit, rel=0.02)


@pytest.mark.parametrize(
    ("mean", "sd"), [(120.0, 0.3), (120.4, 0.2), (0.3, 1.0), (254.8, 0.7), (3.0, 0.6), (99.5, 4.0)]
)
def test_moments_of_rounded_clipped_noise_are_those_of_draws(mean, sd):
    draws = np.random.default_rng(1).normal(mean, sd, DRAWS)
    codes = np.clip(np.rint(draws), 0, 255)
    y = rounded(mean, sd)
    spread = float(y.sd_dn)
    variance_se = spread**2 * math.sqrt((float(y.kurtosis) - 1) / DRAWS)
    assert_agree(
        [codes.mean(), codes.var()],
        [float(y.mean_dn), spread**2],
        [spread / math.sqrt(DRAWS), variance_se],
        f"{mean} {sd}",
    )


@settings(deadline=None, derandomize=True)
@given(st.floats(1.0, 250.0), st.floats(1.0, 5.0))
def test_well_above_a_step_rounding_adds_a_twelfth(mean, sd):
    """Sheppard's correction: what is left is of the order exp(-2 pi^2 sd^2), 3e-9 at one step."""
    mean = np.clip(mean, 10 * sd, 255 - 10 * sd)
    y = rounded(mean, sd)
    assert float(y.mean_dn) == pytest.approx(mean, abs=2e-9)
    assert float(y.sd_dn) ** 2 == pytest.approx(sd**2 + 1 / 12, abs=2e-7)


@settings(deadline=None, derandomize=True)
@given(st.floats(0.0, 255.0))
def test_without_noise_a_level_is_its_nearest_code(mean):
    y = rounded(mean, 0.0)
    assert abs(float(y.mean_dn) - mean) <= 0.5
    assert float(y.sd_dn) == 0


def test_the_sd_of_few_samples_is_low_by_c4():
    y = rounded(100.0, 3.0)
    for n in (2, 10, 100):
        draws = np.rint(np.random.default_rng(n).normal(100, 3, (DRAWS // n, n)))
        sd = draws.std(axis=1, ddof=1)
        assert_agree(sd.mean(), float(y.sample_sd_dn(n)), sd.std() / math.sqrt(len(sd)), f"{n}")
    assert sample_sd_factor(2) == pytest.approx(math.sqrt(2 / math.pi))


@pytest.mark.parametrize("channel", ["R", "G", "B"])
def test_the_column_fit_takes_more_of_demosaiced_noise_than_of_white_noise(channel):
    white = detrended_variance(channel, 50, 50, demosaiced=False)
    assert white == pytest.approx(47 * 50 / 2499)
    kept = detrended_variance(channel, 50, 50, demosaiced=True)
    before = float(np.mean(site_factors(channel, demosaiced=True) ** 2))
    assert kept < white * before


def test_the_lean_measure_is_the_estimators_own():
    rng = np.random.default_rng(7)
    stacks = [np.rint(rng.normal(90, 2, (12, 20, 25))).astype(np.uint8) for _ in range(2)]
    whole = combine(tuple(measure_panel(stack, 255) for stack in stacks))
    expected = whole.mean_dn, whole.temporal_dn, whole.spatial_dn
    assert two_noises(stacks) == pytest.approx(expected, rel=1e-5)


def test_the_technique_with_nothing_exchanged_is_the_estimator(small_seen):
    seen, found = small_seen
    for channel in "RGB":
        ours = parameters(seen[channel], channel, demosaiced=True)
        for key, value in ours.items():
            assert value == pytest.approx(found.channels[channel][key].value, rel=1e-9, abs=1e-12)


def seen_of(found, protocol, size_px=50):
    """The points of a measurement by channel."""
    shots = {shot.label: shot for shot in protocol.shot}
    seen = {}
    for point in found.points:
        shot = shots[point.shot]
        seen.setdefault(point.channel, []).append(
            Seen(
                shot=point.shot,
                dark=shot.dark,
                exposure_s=shot.exposure_s,
                frames=shot.frames,
                rows=size_px,
                mean_dn=point.mean_dn,
                temporal_dn=point.temporal_dn,
                spatial_dn=point.spatial_dn,
            )
        )
    return seen


@pytest.fixture(scope="module")
def small_seen():
    """Panels of a capture, and what the estimator made of them."""
    from analysis.estimators.irie import irie
    from camtruth.simulating import grey_panels, rates_of
    from render.closed_form import render
    from scenes.scene import load as load_scene
    from sensor.camera_file import load as load_camera
    from sensor.mosaic_of_panels import panels_only
    from sensor.protocol import load as load_protocol
    from sensor.record import record

    scene = load_scene("chart")
    images = {lamp: render(scene, lamp) for lamp in scene.lamp_names}
    camera, rates, panels = panels_only(load_camera("i400"), rates_of(images), grey_panels(images))
    found = irie(record(camera, load_protocol("paper"), rates, panels=panels))
    return seen_of(found, load_protocol("paper")), found


def clean(channel: str) -> Make:
    """A camera in which the exact corrections must be exact: nothing clips, noise above a step."""
    return Make(channel=channel, gain=0.05, read=4.0, fpn=1.0, prnu=0.02, black=60.0)


@pytest.mark.parametrize("channel", ["R", "G", "B"])
def test_with_every_step_exchanged_the_closed_form_gives_back_what_went_in(channel):
    """Left: sites of half the noise, 2 DN, whose rounding is 1/12 to 1e-9; c4 of three SDs."""
    make = clean(channel)
    levels = (0.0, 20.0, 40.0, 80.0, 120.0)
    seen = [
        predict(make, shot=f"{light}", light_dn=light, exposure_s=0.03, frames=100)
        for light in levels
    ]
    true = {"read": 4.0, "fpn": 1.0, "shot_coefficient": math.sqrt(0.05), "prnu_slope": 0.02}
    found = parameters(seen, channel, demosaiced=True, black_dn=60.0, technique=REPAIRED)
    printed = parameters(seen, channel, demosaiced=True, black_dn=60.0, technique=PRINTED)
    for key, value in true.items():
        assert found[key] == pytest.approx(value, rel=2e-3), key
    assert abs(printed["shot_coefficient"] / true["shot_coefficient"] - 1) > 0.2


def test_the_domain_finds_the_bias_behind_a_measurement():
    """The technique read on a known camera in closed form; the camera is then forgotten."""
    make = Make(channel="R", gain=0.045, read=1.6, fpn=0.3, prnu=0.0104, black=6.0)
    levels, exposures = (15.0, 30.0, 60.0, 120.0), (0.01, 0.02)
    read = figures(make, exposures_s=exposures, levels_dn=levels, frames=100)
    true = true_figures(make)
    shots = [Shot(label=f"d{t}", exposure_s=t, frames=100) for t in exposures]
    shots.append(Shot(label="lit", light=("l",), level=(1.0,), exposure_s=0.02, frames=100))
    black = np.zeros((100, 60, 60, 3), np.uint8)
    frames = tuple(Frames(dn=black, shot=s, pixels="rgb8", bits=8) for s in shots)
    capture = Capture(camera="t", frames=frames, panels=(Panel(name="1", x=4, y=4, w=50, h=50),))
    points = [
        Point(shot=s.label, panel="1", channel="R", mean_dn=6.0, temporal_dn=1.0, spatial_dn=0.3)
        for s in shots[:2]
    ] + [
        Point(shot="lit", panel="1", channel="R", mean_dn=6 + v, temporal_dn=1, spatial_dn=0.3)
        for v in levels
    ]
    found = NoiseParameters(
        method="irie",
        channels={"R": {k: Estimate(value=v, se=0.001, unit="DN") for k, v in read.items()}},
        points=tuple(points),
    )
    told = foretold(found, capture)["R"]
    for key, value in true.items():
        assert told[key] == pytest.approx(read[key] / value - 1, abs=0.02), key
    assert "fpn R +" in warning(found, capture)[0]
    good = dataclasses.replace(found, channels={"R": {}})
    assert warning(good, capture) == ()
