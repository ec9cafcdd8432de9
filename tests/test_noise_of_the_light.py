"""The noise of the light: told to whoever asks, and so small that no estimator sees it."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from analysis.parameters import Estimate
from camtruth.measuring import measure
from camtruth.options import SAMPLES
from camtruth.simulating import capture_to
from foundation.backend import backend
from foundation.panel import Panel
from render import closed_form, path_traced
from scenes.geometry import analysis_panels
from scenes.scene import load
from sensor.camera_file import load as load_camera
from sensor.protocol import load as load_protocol
from sensor.record import record
from tests.conftest import Run, Small

ROWS = slice(340, 452)
"""The rows of the grey panels: nothing else is analysed."""


@pytest.mark.whole
@pytest.mark.skipif(not backend().jit, reason="two hundred light paths to a pixel take minutes")
def test_at_the_default_no_noise_parameter_moves_by_a_twentieth_of_its_error() -> None:
    """The paper's frames, twice with the same random numbers: under noiseless light, and with the
    very noise that the default leaves of it."""
    scene = load("chart")
    panels = tuple(
        Panel(name=p.name, x=p.x, y=p.y - ROWS.start, w=p.w, h=p.h) for p in analysis_panels(scene)
    )
    camera = dataclasses.replace(load_camera("i400"), height=ROWS.stop - ROWS.start)
    protocol = load_protocol("paper")
    clean, noisy = {}, {}
    for lamp in protocol.lamps:
        exact = closed_form.render(scene, lamp).rate_e_per_s[ROWS]
        image = path_traced.render(scene, lamp, samples=SAMPLES, seed=11)
        assert max(image.header.noise.values()) < 2e-4
        clean[lamp], noisy[lamp] = exact, exact.copy()
        for panel in panels:
            noisy[lamp][panel.window] = image.rate_e_per_s[ROWS][panel.window]
        assert (clean[lamp] != noisy[lamp]).any()
    one, other = (
        measure(record(camera, protocol, light, seed=5, panels=panels)) for light in (clean, noisy)
    )
    moved = {}
    for channel, findings in one.channels.items():
        for key, before in findings.items():
            after = other.channels[channel][key]
            assert isinstance(before, Estimate) == isinstance(after, Estimate)
            if isinstance(before, Estimate) and isinstance(after, Estimate) and before.se:
                moved[channel, key] = abs(after.value - before.value) / before.se
    assert len(moved) >= 15
    assert max(moved.values()) < 1 / 20, moved


def test_the_truth_record_says_how_noisy_the_light_was(tmp_path: Path, small: Small) -> None:
    scene = load("chart").with_size(160, 120)
    image = path_traced.render(scene, "incandescent", samples=8)
    folder = tmp_path / "capture"
    folder.mkdir()
    capture_to(
        folder,
        load_camera(str(small.camera)),
        load_protocol(str(small.protocol)),
        {"incandescent": image},
        panels=image.header.panels,
    )
    light = json.loads((folder / "truth.json").read_text())["light"]["incandescent"]
    assert light["noise"] == pytest.approx(image.header.noise)
    assert light["samples"] == image.header.samples == 8
    assert light["optics"]["bounces"] == 0


def test_render_says_what_the_noise_took(run: Run) -> None:
    """One lamp of a small scene of one's own, to a stated noise, with pictures beside it."""
    text = (Path(__file__).parents[1] / "scenes/presets/chart.toml").read_text()
    text = text.replace("width_px = 640", "width_px = 160").replace(
        "height_px = 480", "height_px = 120"
    )
    Path("mine.toml").write_text(text.replace("pitch_um = 5.6", "pitch_um = 22.4"))
    answer = run("render", "mine.toml", "--noise", "2e-4", "--samples", "8", "--together")
    assert answer.code == 0, answer
    lines = answer.out.splitlines()
    assert [line.split(":")[0].rsplit("/", 1)[-1] for line in lines[:3]] == [
        "rate-incandescent.exr",
        "rate-fluorescent.exr",
        "rate-incandescent+fluorescent.exr",
    ]
    for line in lines[:2]:
        assert float(line.split("relative error ")[1].split()[0]) <= 2e-4
        assert int(line.split(": ")[1].split()[0]) > 8
    assert lines[3].startswith("rendered in ")
    folder = Path("camtruth-out/render")
    for lamp in ("incandescent", "fluorescent"):
        drawing = (folder / f"shading-{lamp}.svg").read_text()
        assert drawing.count("<polyline") == 10
        assert drawing.count("<circle") > 100
        assert "nan" not in drawing
    words = ("--lamp", "incandescent", "--bounces", "1", "--samples", "8")
    answer = run("render", "mine.toml", *words, "--out", "b")
    assert "1 bounce adds" in answer.out
    assert "to direct light" in answer.out
    wrong = run("render", "mine.toml", "--bounces", "99", "--out", "c")
    assert "expected a whole number of at least 0 and at most 16" in wrong.complaint


def test_the_factors_of_shading_make_the_closed_form() -> None:
    """1/R^2, cosine, cos^4 and barrel, multiplied, are the shading of an even card."""
    from render.shading import profiles

    scene = load("uniform").with_size(160, 120)
    image = closed_form.render(scene, "fluorescent")
    for profile in profiles(scene, image):
        product = profile.distance * profile.slant * profile.natural * profile.opening
        np.testing.assert_allclose(product, profile.total, rtol=1e-12)
        np.testing.assert_allclose(profile.lamp, 1, rtol=1e-12)
        np.testing.assert_allclose(profile.measured, profile.total, rtol=1e-6)
