"""The page on which effects are turned up and down: whole, alone, and honest."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from camtruth.exploring import FRAMES, HEIGHT, WIDTH, states, strengths_of
from camtruth.report.pictures import magnified_change
from scenes.scene import load as load_scene
from sensor.camera_file import load as load_camera
from sensor.catalogue import catalogue, effect
from tests.conftest import Run


@pytest.mark.parametrize("kind", [k for k in catalogue().values() if not k.base])
def test_every_effect_has_something_to_turn(kind: type) -> None:
    """Strengths or choices, each inside its range, no two alike; weakest first."""
    shown = strengths_of(kind)
    assert len(shown) > 1
    assert len(set(shown)) == len(shown)


def test_the_difference_is_the_effect_and_nothing_else() -> None:
    """The same random numbers: twice the light moves the dark twice as far. The mean of rounded
    numbers with noise sigma is off by exp(-2 pi^2 sigma^2) / pi at most, in each of three."""
    camera = load_camera("icx098")
    found = list(states(camera, load_scene("chart"), "incandescent", [effect("ambient_light")], 3))
    shape = (FRAMES, HEIGHT, WIDTH, 3)
    assert all(one.lit.with_it.shape == shape == one.dark.without.shape for one in found)
    means = [float((s.dark.with_it.astype(float) - s.dark.without).mean()) for s in found]
    assert means == sorted(means)
    strong, stronger = means[-2:]
    variance = found[0].dark.without.var(axis=0, ddof=1).mean() - 1 / 12
    assert abs(stronger - 2 * strong) < 4 * np.exp(-2 * np.pi**2 * variance) / np.pi
    assert stronger > 5


def test_a_difference_is_magnified_by_what_the_page_says() -> None:
    change = np.zeros((10, 10))
    change[3] = 2.0
    picture, times = magnified_change(change)
    assert times == 50
    assert set(np.unique(picture)) == {128, 128 + 2 * times}


def test_the_page_needs_nothing_else(run: Run, tmp_path: Path) -> None:
    """Every effect asked for is on it, at each strength; it loads nothing and its data is JSON."""
    names = ("smear", "demosaic_other")
    words = [word for name in names for word in ("--effect", name)]
    made = run("explore", *words, "--out", str(tmp_path / "page"))
    assert made.code == 0, made.err
    text = (tmp_path / "page" / "explore.html").read_text(encoding="utf-8")
    assert not re.search(r"(src|href)=.?(https?:)?//", text)
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found is not None
    data = json.loads(found[1])
    assert set(data["effects"]) == set(names)
    for name in names:
        entry = data["effects"][name]
        assert len(entry["states"]) == len(strengths_of(effect(name)))
        for state in entry["states"]:
            assert state["lit"]["with"].startswith("data:image/png;base64,")
            assert state["words"].startswith(f"--with {name}.")
    assert data["effects"]["smear"]["states"][0]["lit"]["same"] is False


@pytest.mark.parametrize(
    "words",
    [("--effect", "smeer"), ("--lamp", "candle"), ("--camera", "none.toml"), ("--seed", "-1")],
)
def test_bad_input_is_one_line(words: tuple[str, ...], run: Run, tmp_path: Path) -> None:
    made = run("explore", *words, "--out", str(tmp_path / "page"))
    assert made.code == 2
    assert made.out == ""
    assert len(made.err.strip().splitlines()) == 1
    assert not (tmp_path / "page").exists()
