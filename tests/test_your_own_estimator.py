"""The estimator of docs/your-own-estimator.md runs as the page says, and is as wrong as it says."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import pytest

from camtruth.measuring import roundtrip
from render.closed_form import render
from scenes.scene import load as load_scene
from sensor.camera_file import load as load_camera
from sensor.effects.demosaic import Demosaic
from sensor.protocol import load as load_protocol
from tests.harness import z_limit

PAGE = Path(__file__).parent.parent / "docs" / "your-own-estimator.md"


@pytest.fixture
def mine(tmp_path):
    (block,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "mine.py").write_text(block, encoding="utf-8")
    body = block[block.index("def mine") :]
    assert len(body.splitlines()) <= 20
    return tmp_path / "mine.py"


@pytest.mark.parametrize("raw", [False, True])
def test_on_colour_frames_it_reads_what_the_demosaic_leaves(mine, raw):
    """9/16 of a variance is left in red and blue, 5/8 in green; all of it on raw frames.

    Means of 54 panels of 2,500 pixels and 100 frames: a thousandth, four for neighbours that share
    samples, and red's small gain beside its read noise ten.
    """
    scene = load_scene("chart")
    images = {lamp: render(scene, lamp) for lamp in scene.lamp_names}
    camera = load_camera("i400")
    if raw:
        camera = dataclasses.replace(camera.without(Demosaic), pixels="bayer8")
    rows = roundtrip(
        camera, load_protocol("paper"), images, seeds=range(2), methods=[f"{mine}:mine"]
    )
    gain = {row.channel: row.estimate / row.truth for row in rows if row.parameter == "gain"}
    left = {"R": 9 / 16, "G": 5 / 8, "B": 9 / 16}
    for channel, share in gain.items():
        expected = 1.0 if raw else left[channel]
        assert share == pytest.approx(expected, abs=z_limit(6) * 0.01), channel


def test_the_commands_of_the_page_take_it(mine, run, small, small_capture):
    name = f"{mine}:mine"
    found = json.loads(run("measure", small_capture, "--method", name, "--json").out)
    assert found["method"] == "mine"
    assert set(found["channels"]["G"]) == {"gain", "read"}
    words = ["roundtrip", "--seeds", 2, *small.words, "--protocol", small.protocol, "--json"]
    told = json.loads(run(*words, "--method", name, "--method", "corrected").out)
    assert {row["method"] for row in told["rows"]} == {"mine", "corrected"}
    figures = {"parameter", "channel", "method", "unit", "truth", "estimate", "bias", "bias_se"}
    assert all(figures | {"rms", "coverage"} <= set(row) for row in told["rows"])
