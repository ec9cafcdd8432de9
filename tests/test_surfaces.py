"""What stands before the lens: patterns, tilt, gloss, and what a booth throws back."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foundation.backend import backend
from foundation.errors import InputError
from render import closed_form, coat, path_traced
from render.bounced import bounced_factor
from render.errors import RenderError
from render.rate import RateImage
from scenes import geometry
from scenes.chart import Gloss
from scenes.check import refuse_impossible
from scenes.errors import SceneError
from scenes.patches import patches
from scenes.scene import Scene, load
from tests.harness import assert_agree, z_limit

UP = np.array([0.0, 0.0, 1.0])


def _changed(scene: Scene, part: str, **changes: Any) -> Scene:
    return dataclasses.replace(
        scene, **{part: dataclasses.replace(getattr(scene, part), **changes)}
    )


def _panels_agree(image: RateImage, truth: RateImage, slack: float) -> None:
    """Panel means within their stated error and a relative slack."""
    rows = [
        (
            image.rate_e_per_s[p.window].mean(axis=(0, 1), dtype=float),
            truth.rate_e_per_s[p.window].mean(axis=(0, 1), dtype=float),
            np.sqrt(image.variance[p.window].mean(axis=(0, 1), dtype=float) / (p.w * p.h)),
        )
        for p in image.header.panels
    ]
    rate, true, error = np.array(rows).transpose(1, 0, 2)
    limit = z_limit(rate.size)
    assert (abs(rate - true) < limit * error + slack * true).all(), abs(rate / true - 1).max()


@pytest.mark.parametrize("name", ["uniform", "edge", "wedge"])
def test_traced_patterns_are_the_closed_form(name: str) -> None:
    scene = load(name).with_size(160, 120)
    image, truth = (
        path_traced.render(scene, "fluorescent"),
        closed_form.render(scene, "fluorescent"),
    )
    assert {p.name for p in image.header.panels} == {p.name for p in patches(scene.chart)}
    for panel in image.header.panels:
        rate, true = (i.rate_e_per_s[panel.window].astype(float) for i in (image, truth))
        np.testing.assert_allclose(rate, true, rtol=2e-3)
    _panels_agree(image, truth, 5e-5)


def test_the_edge_leans_as_it_says() -> None:
    """The edge crosses the middle of the image, 5 degrees off the vertical, to a hundredth of a
    pixel: sums along the rows of the traced image, divided by the shading."""
    scene = load("edge").with_size(160, 120)
    samples = 512 if backend().jit else 128
    image = path_traced.render(scene, "incandescent", samples=samples)
    seen = closed_form.sight(scene)
    even = image.rate_e_per_s[..., 1] / (
        closed_form.irradiance_factor(scene.named("incandescent"), seen.x_m, seen.y_m)
        * closed_form.detector_factor(scene, seen)[0]
    )
    rows, columns = slice(30, 90), slice(50, 110)
    dark, bright = even[60, 50], even[60, 109]
    crossing = columns.stop - ((even[rows, columns] - dark) / (bright - dark)).sum(axis=1)
    slope, at = np.polyfit(np.arange(30, 90) + 0.5 - 60, crossing, 1)
    # N paths place an edge within a pixel to 1/sqrt(12 N) of it; 60 rows share the line.
    error = 1 / np.sqrt(12 * samples * 60)
    assert at == pytest.approx(80, abs=z_limit(2) * error)
    # The top of the edge leans to the right: rows count downwards.
    lean = np.degrees(np.arctan(-slope))
    assert lean == pytest.approx(5.0, abs=z_limit(2) * np.degrees(error * np.sqrt(12) / 60))


def test_a_wedge_has_the_reflectances_that_it_names() -> None:
    """Neighbouring strips at their common gap differ by their reflectances alone."""
    scene = load("wedge")
    image = closed_form.render(scene, "incandescent").rate_e_per_s[..., 1].astype(float)
    seen = closed_form.sight(scene)
    lit = closed_form.irradiance_factor(scene.named("incandescent"), seen.x_m, seen.y_m)
    even = image / (lit * closed_form.detector_factor(scene, seen)[0])
    found = np.array([even[p.window].mean() for p in geometry.panels(scene)])
    expected = np.array(scene.chart.reflectances, dtype=float)
    # The light lies nearer to the axis than the chief ray where the barrel cuts: 1e-3.
    np.testing.assert_allclose(found / found[4], expected / expected[4], rtol=2e-3)


@pytest.mark.parametrize("tilt", [(20.0, 0.0), (0.0, -15.0), (10.0, 12.0)])
def test_a_tilted_card_is_the_closed_form(tilt: tuple[float, float]) -> None:
    scene = _changed(load("chart").with_size(160, 120), "chart", tilt_deg=tilt)
    scene = dataclasses.replace(scene, camera_distance_m=0.42)
    refuse_impossible(scene)
    image, truth = (
        path_traced.render(scene, "fluorescent"),
        closed_form.render(scene, "fluorescent"),
    )
    assert len(image.header.panels) == 24
    # Blur discs on a tilted card are ellipses: at 20 degrees their light is off by 1e-4.
    _panels_agree(image, truth, 2e-4)


def test_tilt_turns_the_card_as_it_says() -> None:
    chart = load("chart")
    top, left = (0.0, 0.1), (-0.1, 0.0)
    forward = _changed(chart, "chart", tilt_deg=(10.0, 0.0))
    assert geometry.place_m(forward, *top)[2] == pytest.approx(0.1 * np.sin(np.radians(10)))
    sideways = _changed(chart, "chart", tilt_deg=(0.0, 10.0))
    assert geometry.place_m(sideways, *left)[2] == pytest.approx(0.1 * np.sin(np.radians(10)))
    for scene in (forward, sideways):
        np.testing.assert_allclose(
            geometry.turn(scene) @ geometry.turn(scene).T, np.eye(3), atol=1e-15
        )
        columns = closed_form.sight(scene)
        np.testing.assert_allclose(
            columns.x_m**2 + columns.y_m**2 + columns.z_m**2,
            columns.card_x_m**2 + columns.card_y_m**2,
            rtol=1e-12,
        )


def test_fresnel_at_known_angles() -> None:
    """Normal incidence, Brewster's angle, and total reflection from inside."""
    normal = coat.fresnel(np.array([1.0]), 1.5)
    assert normal == pytest.approx(0.04)
    brewster = np.cos(np.arctan(1.5))
    s = ((1 - 1.5**2) / (1 + 1.5**2)) ** 2
    assert coat.fresnel(np.array([brewster]), 1.5) == pytest.approx(s / 2)
    assert coat.fresnel(np.array([0.5]), 1 / 1.5) == pytest.approx(1.0)


@pytest.mark.parametrize("roughness", [0.1, 0.3])
def test_facets_cover_the_surface_once(roughness: float) -> None:
    """The projected area of all facets is that of the surface, and the albedo that of the
    highlight integrated over the hemisphere."""
    at, weight = np.polynomial.legendre.leggauss(400)
    angle = (at + 1) * np.pi / 4
    density = coat.facets(np.cos(angle), roughness) * np.cos(angle) * np.sin(angle)
    assert (density * weight).sum() * np.pi / 4 * 2 * np.pi == pytest.approx(1, rel=1e-6)
    gloss = Gloss(roughness=roughness)
    incoming = np.array([np.sin(0.7), 0.0, np.cos(0.7)])
    around = (np.arange(720) + 0.5) * np.pi / 360
    polar, azimuth = np.meshgrid(angle, around, indexing="ij")
    out = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    )
    shine = coat.highlight(np.broadcast_to(incoming, out.shape), out, UP, gloss)
    albedo = (
        ((shine * out[..., 2] * np.sin(polar)).mean(axis=1) * weight).sum() * np.pi / 4 * 2 * np.pi
    )
    reflected, let_in = coat.albedos(incoming[2], roughness, gloss.index)
    assert reflected == pytest.approx(albedo, rel=2e-3)
    assert 0.98 < reflected + let_in <= 1 + 1e-9


@pytest.mark.parametrize("position", [(-0.06, 0.40, 0.45), (0.02, 0.10, 0.50)])
def test_a_traced_coat_is_the_closed_form(position: tuple[float, float, float]) -> None:
    """Far from the mirror image of the lamp, and right in it."""
    scene = _changed(load("chart").with_size(160, 120), "chart", gloss=Gloss(roughness=0.3))
    lamp = dataclasses.replace(scene.lamp[0], position_m=position)
    scene = dataclasses.replace(scene, lamp=(lamp,))
    refuse_impossible(scene)
    image, truth = path_traced.render(scene, lamp), closed_form.render(scene, lamp)
    # Mitsuba tabulates what the coat lets through at 64 angles: 5e-4 of it.
    _panels_agree(image, truth, 1e-3)
    matt = closed_form.render(_changed(scene, "chart", gloss=None), lamp)
    black = image.panel("24").window
    gain = truth.rate_e_per_s[black].mean() / matt.rate_e_per_s[black].mean()
    assert gain < 1.0 if position[1] > 0.3 else gain > 1.5


def test_the_highlight_lies_where_the_mirror_point_says() -> None:
    scene = _changed(load("uniform"), "chart", gloss=Gloss(roughness=0.05), reflectances=(0.0,))
    lamp = dataclasses.replace(scene.lamp[0], position_m=(0.03, -0.05, 0.5))
    scene = dataclasses.replace(scene, lamp=(lamp,))
    image = closed_form.render(scene, lamp).rate_e_per_s[..., 1]
    row, column = np.unravel_index(image.argmax(), image.shape)
    expected = geometry.project(scene, *geometry.mirror_point_m(scene, lamp))
    # D falls by a thousandth within 2 px; 1/R^2 and Fresnel pull the maximum by a few.
    assert (column + 0.5, row + 0.5) == pytest.approx(expected, abs=6)


def test_one_bounce_is_the_integral_over_the_booth() -> None:
    """What a bounce adds to direct light on an even card, in 48 parts of the image and in all."""
    booth = load("chart").booth
    scene = dataclasses.replace(load("uniform").with_size(160, 120), booth=booth)
    lamp = scene.named("fluorescent")
    bounced = path_traced.render(
        scene, lamp, seed=1, bounces=1, samples=288 if backend().jit else 32
    )
    direct = closed_form.render(scene, lamp).rate_e_per_s[..., 1].astype(float)
    seen = closed_form.sight(scene)
    share = bounced_factor(scene, lamp, seen.x_m, seen.y_m) / closed_form.irradiance_factor(
        lamp, seen.x_m, seen.y_m
    )

    def parts(values: np.ndarray) -> np.ndarray:
        return values.reshape(6, 20, 8, 20).mean(axis=(1, 3))

    error = np.sqrt(parts(bounced.variance[..., 1].astype(float) / direct**2) / 400)
    found, expected = parts(bounced.rate_e_per_s[..., 1] / direct - 1), parts(share)
    assert_agree(found, expected, error, "bounced light")
    assert_agree(found.mean(), expected.mean(), np.sqrt((error**2).mean() / 48), "all of it")
    assert expected.mean() > 0.1


def test_nothing_bounces_without_a_booth() -> None:
    """A flat chart sees neither itself nor its wall, but for the panels' 0.3 mm high edges."""
    scene = dataclasses.replace(load("chart").with_size(96, 72), booth=None)
    direct, bounced = (path_traced.render(scene, "incandescent", bounces=n) for n in (0, 3))
    for panel in direct.header.panels:
        before, after = (
            i.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float) for i in (direct, bounced)
        )
        spread = bounced.variance[panel.window].mean(axis=(0, 1), dtype=float)
        error = np.sqrt(spread / (panel.w * panel.h))
        assert (abs(after - before) < z_limit(72) * error + 1e-3 * before).all()


def test_more_bounces_are_refused() -> None:
    with pytest.raises(RenderError, match="99 bounces; expected 0 to 16"):
        path_traced.render(load("chart"), "incandescent", bounces=99)


@pytest.mark.parametrize(
    ("part", "changes", "message"),
    [
        ("chart", {"reflectances": (0.5,)}, "a checker whose reflectances are figures"),
        ("chart", {"panel_m": None}, "without panel_m"),
        ("chart", {"pattern": "edge"}, "of a chart of pattern 'edge'; expected 2 figures"),
        ("chart", {"pattern": "wedge", "reflectances": (0.5,)}, "expected 2 to 40 figures"),
        ("chart", {"pattern": "wedge", "reflectances": (0.5, 0.1), "gap_m": 0.1}, "room for"),
        ("chart", {"tilt_deg": (0.0, 60.0), "width_m": 0.5}, "tilted card comes within"),
        ("booth", {"width_m": 0.2}, "expected the chart inside"),
        ("booth", {"floor_m": 0.106}, "out of the picture"),
        ("booth", {"width_m": 0.319}, "out of the picture"),
    ],
)
def test_a_surface_that_cannot_be_is_refused(
    part: str, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        refuse_impossible(_changed(load("chart"), part, **changes))


@pytest.mark.parametrize(
    ("reflectance", "message"),
    [("-0.1", "at least 0"), ("nan", "finite"), ("1.2", "at most 1")],
)
def test_a_reflectance_that_cannot_be_is_refused(
    tmp_path: Path, reflectance: str, message: str
) -> None:
    preset = Path(__file__).parents[1] / "scenes" / "presets" / "uniform.toml"
    text = preset.read_text().replace("reflectances = [0.9]", f"reflectances = [{reflectance}]")
    (tmp_path / "bad.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        load(str(tmp_path / "bad.toml"))


def test_a_chart_of_ones_own_is_read_from_a_table(tmp_path: Path) -> None:
    nm = np.arange(380, 781, 10)
    head = "nm," + ",".join(str(n) for n in range(1, 25))
    rows = ["".join([f"{x}"] + [f",{n / 30:.4f}" for n in range(1, 25)]) for x in nm]
    (tmp_path / "mine.csv").write_text("\n".join([head, *rows]) + "\n")
    preset = Path(__file__).parents[1] / "scenes" / "presets" / "chart.toml"
    text = preset.read_text().replace('"ColorChecker N Ohta"', '"mine.csv"')
    (tmp_path / "mine.toml").write_text(text)
    found = patches(load(str(tmp_path / "mine.toml")).chart)
    np.testing.assert_allclose(found[11].reflectance.value, 0.4, atol=1e-12)
    (tmp_path / "mine.csv").write_text("\n".join([head, *rows]).replace("0.4000", "-0.4") + "\n")
    from scenes.spectra import reflectances

    reflectances.cache_clear()
    patches.cache_clear()
    with pytest.raises(SceneError, match=r"panel 12 of .* is -0\.4"):
        load(str(tmp_path / "mine.toml"))
