"""The technique as printed, on frames made to its own model and where it cannot tell."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.estimators.irie import irie
from analysis.estimators.parts.hot_pixels import count_hot_pixels
from analysis.parameters import PAPER_KEYS, CannotTell, Estimate
from sensor.frames import Capture, CaptureError, Frames, Panel, Shot, TooFewFrames

LIMIT = 4.5
"""Standard errors: 7e-6 two-sided, below 0.001 over the comparisons of this file."""

EXPOSURE_S = 0.03268
LEVELS = (20.0, 45.0, 80.0, 125.0, 180.0)
SIDE = 50


def panels(count: int) -> tuple[Panel, ...]:
    return tuple(Panel(name=str(k), x=k * SIDE, y=0, w=SIDE, h=SIDE) for k in range(count))


def stack(seed, mean, in_time, frames=60, step=1.0, pixels="mono16", **shot):
    """Frames of a given mean image and SD in time; `step` > 1 makes rounding negligible."""
    noise = np.random.default_rng(seed).normal(0, 1, (frames, *mean.shape))
    dn = np.rint(step * (mean + in_time * noise))
    bits = int(pixels[4:]) if pixels.startswith("mono") else 8
    kind = np.uint16 if bits == 16 else np.uint8
    dn = np.clip(dn, 0, 2**bits - 1).astype(kind)
    return Frames(dn=dn, shot=Shot(frames=frames, **shot), pixels=pixels, bits=bits)


def dark(seed, mean, in_time, exposure_s=EXPOSURE_S, **more):
    label = f"dark-{1e3 * exposure_s:g}ms"
    return stack(seed, mean, in_time, label=label, exposure_s=exposure_s, **more)


def lit(seed, mean, in_time, level=1.0, **more):
    label = f"lamp-{level:g}"
    return stack(
        seed, mean, in_time, label=label, light=("lamp",), level=(level,), exposure_s=EXPOSURE_S,
        **more,
    )  # fmt: skip


def model_capture(seed: int, truth: dict[str, float], columns: int = len(LEVELS)) -> Capture:
    """Frames of a camera whose SDs add as the technique supposes, in steps far above 1 DN.

    In time: read + dark_shot (t / longest) + a sqrt(mu) + b. In space: FPN, and with light
    FPN + slope mu + offset, as one pattern of that size.
    """
    generator = np.random.default_rng([seed, 1])
    pattern = generator.normal(0, 1, (SIDE, SIDE * columns))
    # The technique leaves a root of N of the noise in time in its mean image: here there is none.
    level = np.repeat(LEVELS[:columns], SIDE)[None, :]
    step, frames = 100.0, []
    for k, share in enumerate((0.25, 0.5, 1.0)):
        in_time = truth["read"] + truth["dark_shot"] * share
        mean = 20 + truth["fpn"] * pattern
        frames.append(dark([seed, 2, k], mean, in_time, EXPOSURE_S * share, step=step))
    for k, share in enumerate((0.5, 1.0)):
        mu = 20 + share * level
        in_time = (
            truth["read"]
            + truth["dark_shot"]
            + truth["shot_coefficient"] * np.sqrt(mu)
            + truth["shot_offset"]
        )
        in_space = truth["fpn"] + truth["prnu_slope"] * mu + truth["prnu_offset"]
        frames.append(lit([seed, 3, k], mu + in_space * pattern, in_time, share, step=step))
    return Capture(camera="model", frames=tuple(frames), panels=panels(columns))


MODEL = {
    "read": 1.6,
    "dark_shot": 0.4,
    "shot_coefficient": 0.2,
    "shot_offset": 0.3,
    "fpn": 1.5,
    "prnu_slope": 0.02,
    "prnu_offset": 0.1,
}


def in_steps(truth: dict[str, float], step: float) -> dict[str, float]:
    """The same camera in DN `step` times finer: an SD grows by it, a coefficient of a root by
    its root, a slope not at all."""
    grows = {"shot_coefficient": step**0.5, "prnu_slope": 1.0}
    return {key: value * grows.get(key, step) for key, value in truth.items()}


@pytest.fixture(scope="module")
def runs():
    return [irie(model_capture(seed, MODEL)).channels["Y"] for seed in range(24)]


@pytest.mark.parametrize("key", ["read", "dark_shot", "shot_coefficient", "shot_offset"])
def test_noise_in_time_that_follows_the_model_is_recovered(runs, key):
    values = np.array([run[key].value for run in runs])
    truth = in_steps(MODEL, 100.0)[key]
    # The SD of 60 frames, which N_Q takes back with a curve known to 1.4e-3 / sqrt(2).
    slack = 1.5e-3 * in_steps(MODEL, 100.0)["read"] if key != "shot_coefficient" else 0.005 * truth
    assert abs(values.mean() - truth) < LIMIT * values.std(ddof=1) / len(values) ** 0.5 + slack


@pytest.mark.parametrize("key", PAPER_KEYS)
def test_stated_errors_are_the_scatter_over_bodies_and_frames(runs, key):
    """The fits' misfit factor is 1 or more, so stated errors are a little large, never small."""
    scatter = np.std([run[key].value for run in runs], ddof=1)
    stated = np.sqrt(np.mean([run[key].se ** 2 for run in runs]))
    spread = 1 / np.sqrt(2 * (len(runs) - 1))
    assert 1 - LIMIT / 1.5 * spread < stated / scatter < 1 + LIMIT / 1.5 * spread + 0.3


def test_fpn_keeps_the_noise_in_time_that_averaging_leaves():
    """The known bias: sqrt(FPN^2 + read^2 / N), for steps fine enough to forget rounding."""
    fpn, read, n, step = 0.3, 1.6, 25, 200.0
    pattern = np.random.default_rng(40).normal(0, 1, (SIDE, SIDE * 6))
    frames = dark(41, 50 + fpn * pattern, read, frames=n, step=step)
    found = irie(Capture(camera="x", frames=(frames,), panels=panels(6))).channels["Y"]["fpn"]
    expected = step * np.hypot(fpn, read / np.sqrt(n))
    assert found.value > step * fpn * 1.2
    assert abs(found.value - expected) < LIMIT * found.se + 2e-3 * expected


def test_both_orders_of_equation_10_are_reported():
    """Text: (sigma - N_Q) / N_D. Printed: sigma - N_Q / N_D."""
    found = irie(colour_capture())
    n_d = found.extra["demosaic_factors"]
    for channel in "RGB":
        darks = [p for p in found.points if p.channel == channel and p.shot.startswith("dark")]
        for kind, key in (("spatial", "fpn"), ("temporal", "read")):
            factor = n_d[kind][channel]
            sigma = np.array([getattr(p, f"{kind}_dn") for p in darks])
            n_q = np.array([p.more[f"{kind}_quantization_dn"] for p in darks])
            told = found.extra["dark_means"][channel]
            assert told[key] == pytest.approx(np.mean((sigma - n_q) / factor))
            assert told[f"{key}_printed"] == pytest.approx(np.mean(sigma - n_q / factor))
        assert found.channels[channel]["fpn"].value == pytest.approx(
            found.extra["dark_means"][channel]["fpn"]
        )


def colour_capture(side: int = 50) -> Capture:
    """White noise of 3 DN in each channel, as if a demosaic had left it."""
    generator = np.random.default_rng(42)
    stacks = []
    for label, light, mean, exposure in (
        ("dark-a", "none", 20, 0.01),
        ("dark-b", "none", 20, 0.02),
        ("lamp-1", "lamp", 80, 0.02),
        ("lamp-2", "lamp", 150, 0.02),
    ):
        dn = generator.normal(mean, 3, (20, side, side, 3)).round().astype(np.uint8)
        shot = Shot(label=label, light=(light,), exposure_s=exposure, frames=20)
        stacks.append(Frames(dn=dn, shot=shot, pixels="rgb8", bits=8, cfa="RGGB"))
    area = Panel(name="19", x=0, y=0, w=side, h=side)
    return Capture(camera="x", frames=tuple(stacks), panels=(area,))


def test_the_demosaic_is_divided_out_of_colour_frames_alone():
    found = irie(colour_capture())
    for channel, factor in (("R", 0.73), ("G", 0.75), ("B", 0.73)):
        read = found.channels[channel]["read"]
        assert abs(read.value - 3 / factor) < LIMIT * read.se + 2e-3 * 3 / factor
    mono = tuple(
        Frames(dn=f.dn[..., 1], shot=f.shot, pixels="mono8", bits=8)
        for f in colour_capture().frames
    )
    read = irie(replace(colour_capture(), frames=mono)).channels["Y"]["read"]
    assert abs(read.value - 3) < LIMIT * read.se + 6e-3


def test_native_green_is_read_from_both_of_its_sites():
    generator = np.random.default_rng(43)
    sigma = np.array([[2.0, 3.0], [5.0, 8.0]])  # R G1 / G2 B
    noise = generator.normal(0, 1, (60, 64, 64)) * np.tile(sigma, (32, 32))
    dn = (100 + noise).round().astype(np.uint8)
    shot = Shot(label="dark", exposure_s=0.01, frames=60)
    frames = Frames(dn=dn, shot=shot, pixels="bayer8", bits=8, cfa="RGGB")
    area = Panel(name="a", x=3, y=5, w=50, h=50)
    found = irie(Capture(camera="x", frames=(frames,), panels=(area,))).channels
    for channel, expected in (("R", 2.0), ("G", (3 + 5) / 2), ("B", 8.0)):
        read = found[channel]["read"]
        assert abs(read.value - expected) < LIMIT * read.se + 3e-3 * expected, channel


def test_without_darks_nothing_that_rests_on_them_is_told():
    capture = model_capture(1, MODEL)
    found = irie(replace(capture, frames=capture.lit)).channels["Y"]
    assert all(isinstance(found[key], CannotTell) for key in PAPER_KEYS)
    assert 'light = "none"' in found["read"].reason
    assert "'read'" in found["shot_coefficient"].reason
    assert "'fpn'" in found["prnu_slope"].reason


def test_darks_at_one_exposure_give_read_noise_with_a_warning_and_no_dark_shot():
    capture = model_capture(2, MODEL)
    frames = (capture.darks[-1], *capture.lit)
    found = irie(replace(capture, frames=frames))
    both = 100 * (MODEL["read"] + MODEL["dark_shot"])
    read = found.channels["Y"]["read"]
    assert abs(read.value - both) < LIMIT * read.se + 1.5e-3 * both
    assert isinstance(found.channels["Y"]["dark_shot"], CannotTell)
    assert isinstance(found.channels["Y"]["shot_coefficient"], Estimate)
    assert any("single exposure" in text for text in found.warnings)


def test_one_level_carries_no_curve():
    capture = model_capture(3, MODEL, columns=1)
    found = irie(replace(capture, frames=(*capture.darks, capture.lit[0])))
    for key in ("shot_coefficient", "shot_offset", "prnu_slope", "prnu_offset"):
        assert "one level" in found.channels["Y"][key].reason
    assert isinstance(found.channels["Y"]["fpn"], Estimate)
    only = irie(replace(capture, frames=capture.darks)).channels["Y"]
    assert "lit" in only["prnu_slope"].reason


def test_saturated_panels_are_left_out_and_named():
    level = np.repeat([40.0, 90.0, 150.0, 254.5], SIDE)[None, :] + np.zeros((SIDE, 1))
    frames = (
        dark(44, 20 + 0 * level, 2.0, pixels="mono8", exposure_s=0.01),
        dark(45, 20 + 0 * level, 2.0, pixels="mono8", exposure_s=0.02),
        lit(46, level, 3.0, pixels="mono8"),
    )
    capture = Capture(camera="x", frames=frames, panels=panels(4))
    found = irie(capture)
    assert "saturated, so left out: lamp-1 panel 3 (Y)" in found.warnings
    bright = replace(capture, panels=panels(3))
    theirs = irie(bright).channels["Y"]
    for key in ("shot_coefficient", "prnu_slope"):  # the dark figures still use all four panels
        assert found.channels["Y"][key].value == pytest.approx(theirs[key].value), key
    points = {(p.shot, p.panel): p for p in found.points}
    assert "shot_dn" not in points["lamp-1", "3"].more
    assert "shot_dn" in points["lamp-1", "2"].more


def clipped_capture() -> Capture:
    generator = np.random.default_rng(47)
    stacks = []
    for exposure in (0.025, 2.0):
        dn = np.where(generator.random((4, 80, 80)) < 0.002, 1, 0).astype(np.uint8)
        dn[:, 10, 10] = dn[:, 40, 41] = 30
        dn[0, 60, 60] = 90  # a cosmic ray is no hot pixel
        shot = Shot(label=f"dark-{exposure:g}s", exposure_s=exposure, frames=4)
        stacks.append(Frames(dn=dn, shot=shot, pixels="mono8", bits=8))
    return Capture(camera="x", frames=tuple(stacks))


def test_clipped_darks_tell_no_noise_but_hot_pixels():
    found = irie(clipped_capture())
    for key in ("read", "dark_shot", "fpn"):
        assert "clipped: 99." in found.channels["Y"][key].reason
    assert found.extra["hot_pixels"] == {"dark-0.025s": 2, "dark-2s": 2}
    assert any("clipped at 0 DN" in text for text in found.warnings)


def test_a_demosaic_does_not_multiply_hot_pixels():
    dn = np.full((3, 40, 40, 3), 10, np.uint8)
    dn[:, 9:12, 9:12, 0] = 60
    dn[:, 30, 30, 1] = 60
    shot = Shot(label="dark", exposure_s=1.0, frames=3)
    assert count_hot_pixels(Frames(dn=dn, shot=shot, pixels="rgb8", bits=8)) == 2


def test_frames_that_never_change_are_too_quiet_to_measure():
    dn = np.full((5, 60, 60), 10, np.uint8)
    shot = Shot(label="dark", exposure_s=1.0, frames=5)
    capture = Capture(camera="x", frames=(Frames(dn=dn, shot=shot, pixels="mono8", bits=8),))
    found = irie(capture).channels["Y"]
    assert "rounding" in found["read"].reason
    assert "rounding" in found["fpn"].reason


def test_without_panels_the_centre_is_measured_and_said_so():
    capture = colour_capture(side=90)
    found = irie(replace(capture, panels=()))
    assert any("central 50 x 50" in text for text in found.warnings)
    centre = Panel(name="centre", x=20, y=20, w=50, h=50)
    named = irie(replace(capture, panels=(centre,)))
    assert named.channels == found.channels
    assert not any("central" in text for text in named.warnings)


def test_a_single_frame_and_a_sliver_of_a_panel_are_refused():
    capture = colour_capture()
    one = replace(capture.frames[1], dn=capture.frames[1].dn[:1])
    with pytest.raises(TooFewFrames, match="shot 'dark-b' has 1 frame; expected at least 2"):
        irie(replace(capture, frames=(capture.frames[0], one)))
    sliver = Panel(name="thin", x=0, y=0, w=3, h=20)
    with pytest.raises(CaptureError, match=r"panel 'thin': .*20 x 3 samples"):
        irie(replace(capture, panels=(sliver,)))


def test_the_answer_is_the_contracts_document():
    told = json.loads(json.dumps(irie(colour_capture()).to_json(), allow_nan=False))
    assert (told["format"], told["method"]) == ("camtruth-noise/1", "irie")
    assert set(told["channels"]) == {"R", "G", "B"}
    for found in told["channels"].values():
        assert set(found) == set(PAPER_KEYS)
        assert all({"value", "se", "unit"} == set(e) for e in found.values())
    assert len(told["panels"]) == 4 * 3


REAL = Path(
    os.environ.get(
        "CAMTRUTH_REAL_FRAMES", Path(__file__).resolve().parents[2] / "shared" / "real" / "icx655"
    )
)


@pytest.mark.skipif(not REAL.is_dir(), reason="the real CCD frames are not here")
@pytest.mark.parametrize("sitting", ["d1", "d2"])
def test_real_darks_of_a_ccd_are_clipped_and_show_their_hot_pixels(sitting):
    tifffile = pytest.importorskip("tifffile")
    stacks = []
    for milliseconds in (25, 50, 100, 250, 500, 2000, 3916):
        files = sorted((REAL / "dark_frames").glob(f"{sitting}_dark_{milliseconds}ms_*.tif"))
        dn = np.stack([tifffile.imread(file) for file in files])
        shot = Shot(
            label=f"dark-{milliseconds}ms", exposure_s=milliseconds / 1e3, frames=len(files)
        )
        stacks.append(Frames(dn=dn, shot=shot, pixels="bayer8", bits=8, cfa="GBRG"))
    found = irie(Capture(camera="icx655", frames=tuple(stacks)))
    for channel in "RGB":
        assert "clipped" in found.channels[channel]["read"].reason
    hot = list(found.extra["hot_pixels"].values())
    assert hot[-1] > hot[0]  # dark current brings more of them over the threshold
    assert 10 < hot[-1] < 200  # of 140 thousand
