"""The corrected estimator: no bias of its likelihood, its fits and its whole, in every format."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from analysis.estimators.corrected import corrected
from analysis.estimators.correction.cells import measure_cell
from analysis.estimators.correction.patterns import Covariances, fit_patterns
from analysis.estimators.correction.shading import degree_of, highest
from analysis.estimators.correction.transfer import fit_transfer
from analysis.parameters import UNITS, Estimate
from render.closed_form import render
from scenes.geometry import analysis_panels
from scenes.scene import load as load_scene
from sensor.camera_file import load as load_camera
from sensor.camera_file import with_setting
from sensor.colours import Colours
from sensor.effects.demosaic import Demosaic
from sensor.frames import Capture, Frames, Shot, TooFewFrames
from sensor.mosaic_of_panels import panels_only
from sensor.protocol import load as load_protocol
from sensor.record import record
from sensor.truth import population
from tests.harness import assert_agree

SIDE = 25
FRAMES = 100
ROW, COLUMN = (
    a.ravel() for a in np.meshgrid(2.0 * np.arange(SIDE), 2.0 * np.arange(SIDE), indexing="ij")
)
TRUE = ("read", "fpn", "gain", "dsnu", "prnu", "shot_coefficient", "prnu_slope")
INDEPENDENT = ("read", "fpn", "gain", "prnu")


def codes(seed: int, level: float, noise: float, pattern: float):
    rng = np.random.default_rng(seed)
    mean = level + pattern * rng.normal(size=(SIDE, SIDE))
    samples = mean + noise * rng.normal(size=(FRAMES, SIDE, SIDE))
    return np.clip(np.rint(samples), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("level", "noise", "pattern"),
    [
        (20.0, 0.26, 0.15),
        (20.25, 0.3, 0.1),
        (20.5, 0.3, 0.3),
        (1.0, 0.9, 0.3),
        (254.3, 0.8, 0.2),
        (90.0, 0.5, 2.0),
    ],
)
def test_noise_below_a_step_and_at_the_ends_has_no_bias(level, noise, pattern):
    """Where a variance less 1/12 would be wrong by half of itself and more."""
    cells = [
        measure_cell(codes(seed, level, noise, pattern), 255, ROW, COLUMN) for seed in range(40)
    ]
    found = np.array([cell.variance_dn2 for cell in cells])
    spread = np.array([np.var(c.level_dn, ddof=6) - c.level_variance_dn2 for c in cells])
    assert_agree(
        [found.mean(), spread.mean()],
        [noise**2, pattern**2],
        [found.std(ddof=1) / math.sqrt(40), spread.std(ddof=1) / math.sqrt(40)],
        f"{level} {noise}",
    )
    # The stated error is the scatter: 40 draws tell it to 11 %, four of those are allowed.
    stated = np.mean([cell.variance_se_dn2 for cell in cells])
    assert found.std(ddof=1) / stated == pytest.approx(1.0, abs=4 * 0.113)


def test_a_noise_that_codes_cannot_tell_is_not_told():
    cell = measure_cell(codes(1, 20.0, 0.05, 0.02), 255, ROW, COLUMN)
    assert not cell.told


def test_quiet_noise_under_a_strong_pattern_is_not_told_and_costs_nothing():
    stack = codes(2, 120.0, 0.1, 3.0)
    assert not measure_cell(stack, 255, ROW, COLUMN).told


def test_long_stacks_are_measured_in_sections():
    rng = np.random.default_rng(3)
    stack = np.rint(50.2 + 0.4 * rng.normal(size=(2500, 10, 10))).astype(np.uint8)
    row, column = (a.ravel().astype(float) for a in np.indices((10, 10)))
    cell = measure_cell(stack, 255, row, column)
    assert cell.frames == 2500
    assert_agree(cell.variance_dn2, 0.16, cell.variance_se_dn2, "2500 frames")


def test_one_fpn_and_one_prnu_come_out_of_the_covariances_of_shots():
    """Patterns shared by all shots: errors are those of the sites, not of sites times shots."""
    rng = np.random.default_rng(4)
    level = np.array([0.0, 0.0, 20.0, 60.0, 120.0])
    fpn, prnu, error, sites = 0.3, 0.01, np.full(5, 0.02), 600
    found = []
    for _ in range(60):
        offset, response = rng.normal(size=(2, sites))
        y = fpn * offset + prnu * np.outer(level, response)
        y += np.sqrt(error)[:, None] * rng.normal(size=(5, sites))
        y -= y.mean(axis=1, keepdims=True)
        fit = fit_patterns(
            [
                Covariances(
                    products=y @ y.T / (sites - 1),
                    freedom=sites - 1,
                    light=np.outer(level, level),
                    level=level,
                    lit=level > 0,
                    error=error,
                )
            ]
        )
        found.append((*fit.fpn_dn2, *fit.prnu2))
    f, f_se, p, p_se = np.array(found).T
    assert_agree(
        [f.mean(), p.mean()],
        [fpn**2, prnu**2],
        [f.std(ddof=1) / math.sqrt(60), p.std(ddof=1) / math.sqrt(60)],
        "patterns",
    )
    # 60 draws tell a scatter to 9 %.
    assert f.std(ddof=1) / f_se.mean() == pytest.approx(1.0, abs=4 * 0.092)
    assert p.std(ddof=1) / p_se.mean() == pytest.approx(1.0, abs=4 * 0.092)


def test_read_noise_dark_current_and_gain_are_one_weighted_line():
    rng = np.random.default_rng(5)
    exposure = np.array([0.01, 0.02, 0.03, 0.03, 0.03, 0.03])
    level = np.array([0.0, 0.0, 0.0, 20.0, 60.0, 120.0])
    dark = level == 0
    variance = 0.8 + 0.5 * exposure / 0.03 + 0.05 * level
    se = 0.01 * variance
    found = []
    for _ in range(200):
        fit = fit_transfer(
            variance=variance + se * rng.normal(size=6),
            se=se,
            level=level,
            exposure=exposure,
            dark=dark,
        )
        found.append((fit.read_dn2[0], fit.dark_dn2[0], fit.gain[0], fit.offset_dn[0]))
    mean, scatter = np.mean(found, axis=0), np.std(found, axis=0, ddof=1)
    assert_agree(mean, [0.8, 0.5, 0.05, 0.0], scatter / math.sqrt(200), "transfer")


def test_a_ramp_is_shading_and_not_a_pattern():
    rng = np.random.default_rng(6)
    flat = rng.normal(size=(3, ROW.size))
    limit = highest(SIDE, SIDE)
    assert degree_of(flat, ROW, COLUMN, limit) == 1
    assert degree_of(flat + 0.1 * ROW, ROW, COLUMN, limit) == 2
    assert degree_of(flat + 0.01 * (ROW - 25) ** 3 / 25, ROW, COLUMN, limit) >= 3


@pytest.fixture(scope="module")
def light():
    scene = load_scene("chart")
    rates = {lamp: render(scene, lamp).rate_e_per_s for lamp in scene.lamp_names}
    return rates, analysis_panels(scene)


def shot_with(camera, light, seed=1):
    rates, panels = light
    small, cut, moved = panels_only(camera, rates, panels)
    return record(small.with_body(seed), load_protocol("paper"), cut, seed=seed, panels=moved)


def made(pixels: str):
    """The i400 in another format; with 16 bits a pixel, codes 16 times finer."""
    camera = load_camera("i400")
    if pixels == "rgb8":
        return camera
    camera = dataclasses.replace(camera.without(Demosaic), pixels=pixels)
    if pixels == "bayer8":
        return camera
    fine = dataclasses.replace(
        camera,
        gain_dn_per_e=Colours(**{c: 16 * camera.gain_dn_per_e[c] for c in "RGB"}),
        black_dn=48.0,
        bits=12,
        cfa="GGGG" if pixels == "mono16" else "RGGB",
    )
    for setting in ("read_noise.thermal_dn=14", "fpn.sigma_dn=4"):
        fine = with_setting(fine, setting)
    return fine


@pytest.mark.parametrize("pixels", ["rgb8", "bayer8", "bayer16", "mono16"])
def test_what_went_in_comes_out_of_every_format(pixels, light):
    camera = made(pixels)
    capture = shot_with(camera, light)
    found = corrected(capture)
    assert found.channels.keys() == ({"Y"} if pixels == "mono16" else {"R", "G", "B"})
    assert all(list(of) == list(UNITS) for of in found.channels.values())
    truth = population(camera, 0.03268)
    values, expected, errors = [], [], []
    for channel, findings in found.channels.items():
        for key in INDEPENDENT:
            values.append(findings[key].value)
            expected.append(truth[channel][key])
            errors.append(findings[key].se)
        for key in TRUE:
            assert findings[key].unit == UNITS[key]
        for key in ("shot_offset", "prnu_offset"):  # the model has none
            values.append(findings[key].value)
            expected.append(0.0)
            errors.append(findings[key].se)
    assert_agree(values, expected, errors, pixels)
    assert found.warnings == ()


@pytest.mark.parametrize("cfa", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_the_mosaic_is_recognised_where_nobody_stated_it(cfa, light):
    capture = shot_with(dataclasses.replace(load_camera("i400"), cfa=cfa), light)
    silent = dataclasses.replace(
        capture, frames=tuple(dataclasses.replace(f, cfa=None) for f in capture.frames)
    )
    found = corrected(silent)
    assert found.extra["mosaic"]["cfa"] == cfa
    assert any(cfa in warning for warning in found.warnings)
    stated = corrected(capture)
    assert found.channels == stated.channels


def test_clipped_darks_and_single_levels_are_no_figures(light):
    camera = dataclasses.replace(load_camera("i400"), black_dn=-3.0)
    clipped = corrected(shot_with(camera, light))
    assert "clipped" in clipped.channels["G"]["read"].reason
    darks = dataclasses.replace(
        (whole := shot_with(load_camera("i400"), light)),
        frames=tuple(f for f in whole.frames if f.shot.dark),
    )
    found = corrected(darks).channels["G"]
    assert isinstance(found["read"], Estimate)
    for key in ("gain", "prnu", "shot_coefficient", "prnu_slope"):
        assert "no lit panel" in found[key].reason


def test_no_pattern_is_not_reported_as_one(light):
    camera = with_setting(load_camera("i400"), "prnu.ratio=0")
    found = corrected(shot_with(camera, light))
    for findings in found.channels.values():
        assert "not seen" in findings["prnu"].reason


def test_noise_far_below_a_step_is_not_told(light):
    camera = with_setting(load_camera("i400"), "read_noise.thermal_dn=0.05")
    found = corrected(shot_with(camera, light))
    assert "too far below one step" in found.channels["R"]["read"].reason


def test_a_single_frame_is_refused():
    shot = Shot(label="dark", exposure_s=0.01, frames=1)
    frames = Frames(dn=np.zeros((1, 20, 20), np.uint8), shot=shot, pixels="mono8", bits=8)
    with pytest.raises(TooFewFrames):
        corrected(Capture(camera="one", frames=(frames,)))
