"""The camera response as data: filters, tables of one's own, and what an error in them does."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from render.errors import RenderError
from render.perturbed import KINDS, changes, perturbed
from render.spectral import material_rates
from scenes.errors import SpectrumError
from scenes.scene import load
from scenes.spectra import CHANNELS, response
from tests.conftest import Run


def _table(path: Path, rows: list[tuple[float, ...]], head: str) -> str:
    path.write_text(head + "\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
    return str(path)


def test_an_infrared_cut_filter_stands_before_the_sensor(tmp_path: Path) -> None:
    nm = np.arange(380, 1001, 10)
    bare = _table(tmp_path / "bare.csv", [(x, 1, 2, 4) for x in nm], "nm,R,G,B")
    with pytest.raises(SpectrumError, match="name the camera's infrared cut filter"):
        response(bare)
    cut = _table(tmp_path / "cut.csv", [(x, 0.9 if x < 650 else 0) for x in nm], "nm,value")
    seen = response(bare, cut)
    assert seen["B"].at(500.0) == pytest.approx(1.0)
    assert seen["R"].at(500.0) == pytest.approx(0.25)
    # Linear between 640 and 650 nm, where the table falls from 0.9 to 0.
    assert seen["B"].at(645.0) == pytest.approx(0.5)
    assert not seen["B"].at(np.array([655.0, 700.0, 900.0])).any()


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([(x, 1.2) for x in range(400, 701, 10)], "transmits 1.2"),
        ([(x, -0.2) for x in range(400, 701, 10)], "-0.2 at 400 nm"),
        ([(x, "nan") for x in range(400, 701, 10)], "NaN or infinity"),
        ([(x, 1) for x in range(450, 701, 10)], "covers 450 to 700 nm"),
    ],
)
def test_a_bad_filter_is_refused(
    tmp_path: Path, rows: list[tuple[float, float]], message: str
) -> None:
    with pytest.raises(SpectrumError, match=message):
        response("surrogate", _table(tmp_path / "bad.csv", rows, "nm,value"))


def test_a_level_changes_all_panels_by_itself() -> None:
    scene = load("chart")
    rows = [c for c in changes(scene, scene.lamp[0], 0.2) if c.kind == "level"]
    assert {row.channel for row in rows} == set(CHANNELS)
    for row in rows:
        assert (row.grey, row.worst) == pytest.approx((0.2, 0.2))
        assert row.spread == pytest.approx(0, abs=1e-12)
        assert row.shot_noise == pytest.approx(np.sqrt(1.2) - 1)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_changes_are_linear_and_of_one_channel_alone(kind: str) -> None:
    """Rates are linear in the response: twice the perturbation, twice the change."""
    scene = load("chart")
    lamp, curves = scene.named("fluorescent"), response("surrogate")
    before = material_rates(scene, lamp, curves)
    one, two = (
        material_rates(scene, lamp, perturbed(curves, "G", kind, e)) - before for e in (0.1, 0.2)
    )
    np.testing.assert_allclose(two, 2 * one, rtol=1e-9, atol=1e-9 * before.max())
    assert not one[:, [0, 2]].any()
    assert one[:, 1].any()


def test_grey_panels_change_alike_and_coloured_ones_do_not() -> None:
    """A tilt of 10 % moves greys together within half a percent, and some colour by more."""
    scene = load("chart")
    for lamp in scene.lamp:
        for row in changes(scene, lamp, 0.1):
            assert row.spread < 0.005
            assert abs(row.worst) <= 0.1 * (1 + 1e-9) + (row.kind == "leak")
    with pytest.raises(RenderError, match=r"expected 0\.001 to 0\.5"):
        changes(scene, scene.lamp[0], 2.0)


def test_the_command_reports_it(run: Run) -> None:
    answer = run("response", "--size", "0.1", "--json")
    found = json.loads(answer.out)
    assert found["format"] == "camtruth-response/1"
    assert len(found["changes"]) == 2 * 3 * 4
    shown = run("response", "wedge").out
    assert "grey spread" in shown
    assert shown.count("incandescent") == 24
    assert "unknown camera response 'icx'" in run("response", "--response", "icx").complaint
    assert "expected a number of at least 0.001" in run("response", "--size", "9").complaint
