"""Scenes: what may stand before the camera, and where it falls in the image."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foundation.errors import DocumentError, InputError
from scenes import geometry
from scenes.check import refuse_impossible, refuse_specular
from scenes.errors import SceneError, SpectrumError
from scenes.lamp import Filter
from scenes.lamps import emission, transmission
from scenes.scene import Scene, load, preset_names
from scenes.spectra import CHANNELS, lamp_spectrum, reflectances, response, spectrum

PRESET = Path(__file__).parents[1] / "scenes" / "presets" / "chart.toml"


@pytest.fixture(scope="module")
def chart() -> Scene:
    return load("chart")


def _changed(scene: Scene, part: str, **changes: Any) -> Scene:
    return dataclasses.replace(
        scene, **{part: dataclasses.replace(getattr(scene, part), **changes)}
    )


def test_every_preset_can_be_photographed() -> None:
    assert preset_names()
    for name in preset_names():
        refuse_impossible(load(name))


def test_the_chart_has_the_lamps_and_panels_of_the_contract(chart: Scene) -> None:
    assert chart.lamp_names == ("incandescent", "fluorescent")
    names = [panel.name for panel in geometry.panels(chart)]
    assert names == [str(number) for number in range(1, 25)]
    place = {panel.name: (panel.x, panel.y) for panel in geometry.panels(chart)}
    assert place["1"] == min(place.values(), key=sum)
    assert place["24"] == max(place.values(), key=sum)
    assert place["6"][0] > place["1"][0]
    assert place["6"][1] == place["1"][1]


def test_edges_blur_over_three_to_six_pixels(chart: Scene) -> None:
    assert 3 <= geometry.blur_diameter_px(chart) <= 6


def test_panels_keep_a_blur_diameter_from_their_edges(chart: Scene) -> None:
    blur = geometry.blur_diameter_px(chart)
    for panel in geometry.panels(chart):
        where = geometry.panel_rectangles(chart)[panel.name]
        left, top = geometry.project(chart, where.left_m, where.top_m)
        right, bottom = geometry.project(chart, where.right_m, where.bottom_m)
        margins = (
            panel.x - left,
            panel.y - top,
            right - (panel.x + panel.w),
            bottom - (panel.y + panel.h),
        )
        assert all(blur <= margin < blur + 1 for margin in margins)


def test_the_papers_areas_lie_in_the_middle_of_their_panels(chart: Scene) -> None:
    clear = {panel.name: panel for panel in geometry.panels(chart)}
    for area in geometry.analysis_panels(chart, names=geometry.PANEL_NAMES):
        panel = clear[area.name]
        assert (area.w, area.h) == (50, 50)
        assert abs((area.x - panel.x) - (panel.x + panel.w - area.x - 50)) <= 2
        assert abs((area.y - panel.y) - (panel.y + panel.h - area.y - 50)) <= 2


def test_an_area_larger_than_its_panel_is_refused(chart: Scene) -> None:
    with pytest.raises(SceneError, match="90 x 90 px in panel '19'"):
        geometry.analysis_panels(chart, size_px=90)
    with pytest.raises(SceneError, match="unknown panel '25'"):
        geometry.analysis_panels(chart, names=("25",))


def test_the_mirror_point_obeys_the_law_of_reflection(chart: Scene) -> None:
    camera = np.array([0, 0, chart.camera_distance_m])
    for lamp in chart.lamp:
        point = np.array([*geometry.mirror_point_m(chart, lamp), 0.0])
        incoming = point - np.array(lamp.position_m)
        outgoing = camera - point
        mirrored = incoming * [1, 1, -1]
        np.testing.assert_allclose(
            mirrored / np.linalg.norm(mirrored), outgoing / np.linalg.norm(outgoing), atol=1e-12
        )


def test_a_lamp_that_the_card_mirrors_into_the_lens_is_refused(chart: Scene) -> None:
    near = dataclasses.replace(chart.lamp[0], position_m=(0.0, 0.20, 0.45))
    with pytest.raises(SceneError, match="'incandescent' is mirrored into the lens"):
        refuse_specular(dataclasses.replace(chart, lamp=(near,)))
    refuse_specular(chart)


@pytest.mark.parametrize(
    ("part", "changes", "message"),
    [
        ("lens", {"focus_distance_m": 0.004}, "forms no image"),
        ("lens", {"f_number": 0.9}, "before an aperture of"),
        ("chart", {"panel_m": 0.05}, "chart width_m"),
        ("chart", {"reflectances": "ColorChecker"}, "unknown table of reflectances"),
        ("detector", {"response": "icx"}, "unknown camera response"),
        ("detector", {"width_px": 16, "height_px": 8}, "no panel of scene"),
        ("calibration", {"panel": "grey"}, "unknown calibration panel"),
    ],
)
def test_a_scene_that_cannot_be_is_refused(
    chart: Scene, part: str, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        refuse_impossible(_changed(chart, part, **changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"position_m": (0.0, 0.4, -0.4)}, "not before the chart"),
        ({"spd": "FL99"}, "unknown lamp spectrum 'FL99'"),
        ({"name": "fluorescent"}, "two lamps are called"),
    ],
)
def test_a_lamp_that_cannot_be_is_refused(
    chart: Scene, changes: dict[str, Any], message: str
) -> None:
    lamps = (dataclasses.replace(chart.lamp[0], **changes), chart.lamp[1])
    with pytest.raises(SceneError, match=message):
        refuse_impossible(dataclasses.replace(chart, lamp=lamps))


def test_unknown_names_are_refused_with_the_known_ones(chart: Scene) -> None:
    with pytest.raises(SceneError, match=r"unknown scene 'chrat'; .*did you mean 'chart'"):
        load("chrat")
    with pytest.raises(SceneError, match=r"unknown lamp 'incandecent'; .*did you mean 'incand"):
        chart.named("incandecent")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("f_number = 2.0", "f_numbre = 2.0", "unknown key 'lens.f_numbre'"),
        ("pitch_um = 5.6", "pitch_um = -5.6", "expected a number above 0;"),
        ("pitch_um = 5.6", "pitch_um = nan", "finite number"),
        ('kind = "point"', 'kind = "laser"', "point"),
    ],
)
def test_a_misspelt_scene_file_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = PRESET.read_text()
    assert old in text
    (tmp_path / "mine.toml").write_text(text.replace(old, new))
    with pytest.raises(DocumentError, match=message) as caught:
        load(str(tmp_path / "mine.toml"))
    assert "\n" not in str(caught.value)


def test_a_scene_of_ones_own_finds_its_tables_beside_it(tmp_path: Path) -> None:
    nm = np.arange(400, 701, 5)
    (tmp_path / "led.csv").write_text("# mine\nnm,value\n" + "".join(f"{x},1\n" for x in nm))
    (tmp_path / "cam.csv").write_text("nm,R,G,B\n" + "".join(f"{x},1,2,4\n" for x in nm))
    text = PRESET.read_text().replace('spd = "A"', 'spd = "led.csv"')
    text = text.replace('response = "surrogate"', 'response = "cam.csv"')
    (tmp_path / "mine.toml").write_text(text)
    scene = load(str(tmp_path / "mine.toml"))
    flat = lamp_spectrum(scene.lamp[0].spd)
    np.testing.assert_allclose(flat.value, 1 / 300)
    peaks = [response(scene.detector.response)[channel].value.max() for channel in CHANNELS]
    np.testing.assert_allclose(peaks, [0.25, 0.5, 1.0])


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([(420, 1), (700, 1)], "covers 420 to 700 nm"),
        ([(x, 1) for x in range(400, 701, 10)], "samples 10 nm apart"),
        ([(x, -1) for x in range(400, 701, 5)], "-1 at 400 nm"),
        ([(x, "nan") for x in range(400, 701, 5)], "NaN or infinity"),
        ([(x, "dark") for x in range(400, 701, 5)], "expected a number in every cell"),
        ([(x, 0) for x in range(400, 701, 5)], "zero everywhere"),
        ([(x, 1) for x in range(700, 399, -5)], "do not rise"),
        ([], "has no rows"),
    ],
)
def test_an_unusable_lamp_table_is_refused(
    tmp_path: Path, rows: list[tuple[Any, Any]], message: str
) -> None:
    path = tmp_path / "lamp.csv"
    path.write_text("nm,value\n" + "".join(f"{nm},{value}\n" for nm, value in rows))
    with pytest.raises(SpectrumError, match=message):
        lamp_spectrum(str(path))


def test_a_camera_that_sees_infrared_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "camera.csv"
    path.write_text("nm,R,G,B\n" + "".join(f"{x},1,1,1\n" for x in range(400, 1001, 10)))
    with pytest.raises(SpectrumError, match="sees light outside"):
        response(str(path))
    with pytest.raises(InputError, match="cannot read"):
        response(str(tmp_path / "absent.csv"))


def test_lamp_spectra_are_normalised_and_keep_their_mercury_lines(chart: Scene) -> None:
    for name in ("A", "FL2", "FL11", "Philips TL-84"):
        assert lamp_spectrum(name).integral(400, 700) == pytest.approx(1, abs=1e-12)
    line = lamp_spectrum("FL2")
    assert line.at(435) > 3 * line.at(425)
    for lamp in chart.lamp:
        bare = dataclasses.replace(lamp, filter=None)
        assert emission(bare).integral(400, 700) == pytest.approx(lamp.intensity_w_per_sr)


def test_a_gel_absorbs_and_moves_a_black_body_as_wien_says() -> None:
    nm = np.arange(400.0, 701)
    for gel in (
        Filter(mired_shift=-200, green_density=0.5),
        Filter(mired_shift=100, green_density=-0.3),
    ):
        assert transmission(gel, nm).max() == pytest.approx(gel.peak_transmission)
        assert transmission(gel, nm).min() > 0
    c2 = 1.438776877e7
    warm, cold = (np.exp(-c2 / (nm * kelvin)) / nm**5 for kelvin in (2856.0, 5000.0))
    shift = 1e6 / 5000 - 1e6 / 2856
    ratio = warm * transmission(Filter(mired_shift=shift, green_density=0), nm) / cold
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)


def test_reflectances_are_those_of_colour_science() -> None:
    from scenes.colour_science import colour

    measured = list(colour.SDS_COLOURCHECKERS["ColorChecker N Ohta"].values())
    for ours, theirs in zip(reflectances("ColorChecker N Ohta"), measured, strict=True):
        np.testing.assert_allclose(ours.at(theirs.wavelengths), theirs.values, atol=1e-12)
    wide = reflectances("BabelColor Average")[18]
    assert wide.at(780) == pytest.approx(wide.at(730))


def test_a_spectrum_integrates_exactly_what_is_linear() -> None:
    ramp = spectrum([400, 500, 700], [0.0, 1.0, 1.0])
    assert ramp.integral(400, 700) == pytest.approx(250)
    assert ramp.integral(450, 600) == pytest.approx(37.5 + 100)
    with pytest.raises(ValueError, match="read-only"):
        ramp.value[0] = 1
