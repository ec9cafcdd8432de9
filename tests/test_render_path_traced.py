"""Traced light against the closed form, on every backend that works here.

Pixels are independent, so the error of each is known from its own batches; tests compare at the
significance stated, divided by the number of comparisons made.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from foundation.backend import CHOICE_VARIABLE, backend, probe
from render import closed_form, path_traced
from render.errors import RenderError
from render.pupil import open_fraction
from render.rate import RateImage
from scenes import geometry
from scenes.errors import SceneError
from scenes.scene import Scene, load

SIGNIFICANCE = 1e-4
SIZES = {"scalar": (160, 120), "llvm": (320, 240), "cuda": (320, 240)}
BATCHES = path_traced.BATCHES


@pytest.fixture(params=sorted(SIZES))
def backend_name(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    name = str(request.param)
    if not probe(name).works:  # type: ignore[arg-type]
        pytest.skip(f"backend {name}: {probe(name).found}")  # type: ignore[arg-type]
    monkeypatch.setenv(CHOICE_VARIABLE, name)
    return name


@pytest.fixture(scope="module")
def chart() -> Scene:
    return load("chart").with_size(*SIZES[backend().name])


def _without_barrel(scene: Scene) -> Scene:
    return dataclasses.replace(scene, lens=dataclasses.replace(scene.lens, barrel=None))


def _inside(image: RateImage, truth: RateImage) -> tuple[np.ndarray, np.ndarray]:
    """Errors and standard errors of all pixels inside panels, (N, 3)."""
    windows = [panel.window for panel in image.header.panels]
    error = [
        (image.rate_e_per_s[w].astype(float) - truth.rate_e_per_s[w]).reshape(-1, 3)
        for w in windows
    ]
    sigma = [np.sqrt(image.variance[w].astype(float)).reshape(-1, 3) for w in windows]
    return np.concatenate(error), np.concatenate(sigma)


@pytest.mark.parametrize("lamp", ["incandescent", "fluorescent"])
def test_inside_panels_it_is_the_closed_form(backend_name: str, lamp: str) -> None:
    """Every pixel within 0.2 %, and every panel within its stated Monte Carlo error."""
    scene = load("chart").with_size(*SIZES[backend_name])
    image, truth = path_traced.render(scene, lamp, seed=1), closed_form.render(scene, lamp)
    assert len(image.header.panels) == 24
    # A quotient of two mean squares of n pixels, of 1 and of K - 1 degrees of freedom each.
    level = SIGNIFICANCE / (24 * 3)
    for panel in image.header.panels:
        rate, true = (i.rate_e_per_s[panel.window].astype(float) for i in (image, truth))
        np.testing.assert_allclose(rate, true, rtol=2e-3)
        quotient = ((rate - true) ** 2).mean(axis=(0, 1)) / image.variance[panel.window].mean(
            axis=(0, 1), dtype=float
        )
        pixels = panel.w * panel.h
        assert (quotient < stats.f.isf(level, pixels, pixels * (BATCHES - 1))).all(), panel
    assert max(image.header.noise.values()) < 5e-4


def test_the_stated_error_is_honest(chart: Scene) -> None:
    """Errors in units of the stated one follow Student's t with K - 1 degrees of freedom."""
    truth = closed_form.render(chart, "fluorescent")
    scores = []
    for seed in range(3):
        error, sigma = _inside(path_traced.render(chart, "fluorescent", seed=seed), truth)
        scores.append((error / sigma)[:, 1])
    every = np.concatenate(scores)
    every = every[:: max(1, every.size // 20_000)]
    found = stats.kstest(every, stats.t(BATCHES - 1).cdf)
    assert found.pvalue > SIGNIFICANCE
    normal = stats.kstest(every, stats.norm.cdf)
    assert normal.pvalue < SIGNIFICANCE, "the test could not tell t from a normal distribution"


def test_drawn_wavelengths_come_to_the_same(chart: Scene) -> None:
    """Colour integrated beforehand and colour drawn path by path, under mercury lines."""
    truth = closed_form.render(chart, "fluorescent")
    image = path_traced.render(chart, "fluorescent", seed=2, samples=288, wavelengths="sampled")
    level = SIGNIFICANCE / (24 * 3 * 2)
    for panel in image.header.panels:
        # A film of 1 nm leaves 1e-4 of a spectrum's curvature: see render/palette.py.
        true = truth.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float)
        mean = image.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float)
        variance = image.variance[panel.window].mean(axis=(0, 1), dtype=float)
        error = np.sqrt(variance / (panel.w * panel.h))
        assert (abs(mean - true) < stats.norm.isf(level) * error + 1e-4 * true).all(), panel


def test_without_a_witness_it_is_the_same_picture_with_more_noise(chart: Scene) -> None:
    """Plain Mitsuba, batch by batch: nothing divided out, nothing known beforehand."""
    truth = closed_form.render(chart, "incandescent")
    plain = path_traced.render(chart, "incandescent", witness=False, samples=288)
    level = SIGNIFICANCE / (24 * 3 * 2)
    for panel in plain.header.panels:
        true = truth.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float)
        mean = plain.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float)
        variance = plain.variance[panel.window].mean(axis=(0, 1), dtype=float)
        error = np.sqrt(variance / (panel.w * panel.h))
        assert (abs(mean - true) < stats.norm.isf(level) * error + 1e-5 * true).all(), panel
    assert (
        plain.header.noise["G"] > 20 * path_traced.render(chart, "incandescent").header.noise["G"]
    )


def test_multijitter_is_worth_its_name(chart: Scene) -> None:
    """Plain independent paths need over a hundred times the samples for the same noise."""
    poor = path_traced.render(chart, "fluorescent", sampler="independent", witness=False)
    good = path_traced.render(chart, "fluorescent", sampler="multijitter")
    assert (poor.header.noise["G"] / good.header.noise["G"]) ** 2 > 100


def test_the_barrel_stops_what_geometry_says(backend_name: str) -> None:
    """The traced open part of the aperture, ring by ring, without any help from the weights."""
    scene = load("chart").with_size(*SIZES[backend_name])
    mean, variance = path_traced.traced_open_fraction(scene, samples=288, seed=5)
    exact = open_fraction(scene)
    rows, columns = np.indices(exact.shape)
    radius = np.hypot(columns - exact.shape[1] / 2, rows - exact.shape[0] / 2)
    rings = np.digitize(radius, np.linspace(0, radius.max(), 11)[1:-1])
    level = SIGNIFICANCE / (10 * 2)
    for ring in range(10):
        at = rings == ring
        error = np.sqrt(variance[at].sum()) / at.sum()
        difference = abs(mean[at].mean() - exact[at].mean())
        # 1e-5: 512 sides for a circle, and the slices of `open_fraction`
        assert difference < stats.norm.isf(level) * error + 1e-5
    assert exact[rings == 9].mean() < 0.85


def test_without_a_barrel_no_light_is_cut(chart: Scene) -> None:
    bare = _without_barrel(chart)
    image, truth = path_traced.render(bare, "fluorescent"), closed_form.render(bare, "fluorescent")
    error, sigma = _inside(image, truth)
    assert (error**2).mean() < 1.1 * (sigma**2).mean()
    cut = path_traced.render(chart, "fluorescent").rate_e_per_s[:10, :10].mean()
    assert cut < 0.9 * image.rate_e_per_s[:10, :10].mean()


def test_defocus_is_that_of_a_thin_lens() -> None:
    """The line spread of an edge has the variance of a disc seen from the side, r^2 / 4.

    The edge is the left one of panel 16, in a detector cropped to the middle of the chart. A
    square pixel adds 1/12, and so does the difference of neighbours that takes the place of the
    derivative. Twenty pieces of the edge give the error.
    """
    scene = _without_barrel(load("chart"))
    detector = dataclasses.replace(scene.detector, width_px=160, height_px=120)
    scene = dataclasses.replace(scene, detector=detector)
    image = path_traced.render(scene, "fluorescent", samples=288)
    where = geometry.panel_rectangles(scene)["16"]
    edge, top = geometry.project(scene, where.left_m, where.top_m)
    blur = geometry.blur_diameter_px(scene)
    columns = slice(round(edge - blur - 2), round(edge + blur + 2))
    seen = closed_form.sight(scene)
    shading = closed_form.irradiance_factor(scene.named("fluorescent"), seen.x_m, seen.y_m)
    even = image.rate_e_per_s[..., 1] / (shading * closed_form.natural_falloff(seen.slope))
    at = np.arange(columns.start, columns.stop - 1) + 1.0
    centres, variances = [], []
    for rows in np.array_split(np.arange(round(top + blur), 120), 20):
        spread = np.diff(even[rows, columns].mean(axis=0))
        spread /= spread.sum()
        centres.append((spread * at).sum())
        variances.append((spread * (at - centres[-1]) ** 2).sum())
    width = stats.t.isf(SIGNIFICANCE / 4, 19) / np.sqrt(20)
    tolerance = width * np.std(variances, ddof=1)
    assert tolerance < 0.08
    assert np.mean(variances) == pytest.approx(blur**2 / 16 + 2 / 12, abs=tolerance)
    # The panel stands 0.3 mm proud and throws a shadow of 0.1 px on the card, a tenth as bright.
    assert np.mean(centres) == pytest.approx(edge, abs=width * np.std(centres, ddof=1) + 0.02)


def test_the_seed_decides(chart: Scene, backend_name: str) -> None:
    small = chart.with_size(64, 48)
    one, again, other = (path_traced.render(small, "incandescent", seed=s) for s in (4, 4, 5))
    np.testing.assert_array_equal(one.rate_e_per_s, again.rate_e_per_s)
    assert (one.rate_e_per_s != other.rate_e_per_s).mean() > 0.9


def test_it_renders_until_the_noise_is_reached(chart: Scene) -> None:
    calls: list[tuple[int, int]] = []
    small = chart.with_size(128, 96)
    image = path_traced.render(
        small, "incandescent", samples=8, noise=4e-4, progress=lambda *call: calls.append(call)
    )
    assert max(image.header.noise.values()) <= 4e-4
    assert image.header.samples > 8
    assert [done for done, _ in calls] == list(range(1, len(calls) + 1))
    assert calls[-1][0] == calls[-1][1] == image.header.samples
    with pytest.raises(RenderError, match="a noise of 1e-09 would take about"):
        path_traced.render(small, "incandescent", samples=8, noise=1e-9)


def test_the_header_says_where_it_came_from(chart: Scene) -> None:
    small = chart.with_size(128, 96)
    header = path_traced.render(small, "fluorescent", seed=9, samples=30).header
    assert (header.scene, header.lamp, header.seed, header.samples) == (
        "chart",
        "fluorescent",
        9,
        32,
    )
    assert header.panels == geometry.panels(small)
    assert header.optics["f_number"] == 2.0
    assert header.optics["barrel_radius_mm"] == 1.75
    assert {"mitsuba", "drjit", "numpy", "colour-science"} <= set(header.versions)


def test_bad_requests_are_refused(chart: Scene) -> None:
    for wrong in ({"samples": 0}, {"seed": -1}, {"noise": 0.0}, {"noise": float("nan")}):
        with pytest.raises(RenderError):
            path_traced.render(chart, "fluorescent", **wrong)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="unknown lamp 'sun'"):
        path_traced.render(chart, "sun")
    with pytest.raises(SceneError, match="unknown lamp 'sun'"):
        closed_form.render(chart, "sun")
