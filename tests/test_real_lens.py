"""A real lens: against its patent, an independent ray, and the ideal lens that it becomes."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from docs.light_page import LENSES
from foundation.backend import CHOICE_VARIABLE, backend
from foundation.errors import InputError
from render import closed_form, path_traced
from render.errors import RenderError
from scenes.check import refuse_impossible
from scenes.errors import SceneError
from scenes.field import WAVELENGTHS_NM, field
from scenes.geometry import panel_rectangles, panels, project
from scenes.imaging import corner_m, real_field
from scenes.lens import Barrel, Lens
from scenes.prescription import (
    D_NM,
    Surface,
    load_prescription,
    matrix,
    mounted,
    prescription_names,
)
from scenes.ray_trace import Rays, trace
from scenes.scene import load
from tests.harness import z_limit
from tests.lens_bench import SIZE, batch, chief_by_search, in_chart, independent_ray

LENS = {name: dataclasses.replace(lens, transmission=0.9) for name, lens in LENSES.items()}

IDEAL = """
name = "ideal"
source = "a thin lens and the barrel of the preset chart"
focal_length = 4.3
surface = [
    { thickness = 2.5, rim = 1.75 },
    { thickness = 0.0, rim = 1.2, stop = true },
    { thickness = 0.0, rim = 9.0, ideal_focal_length = 4.3 },
]
"""


needs_jit = pytest.mark.skipif(
    not backend().jit, reason="real lenses are traced on LLVM and CUDA alone"
)


@pytest.mark.parametrize("name", sorted(LENS))
def test_a_prescription_has_the_focal_length_of_its_patent(name: str) -> None:
    lens = load_prescription(name)
    # Three digits are printed of radii and thicknesses: half a digit of each makes some 0.3 %.
    assert -1 / matrix(lens.surface)[1, 0] == pytest.approx(lens.focal_length, rel=4e-3)
    assert "patent" in lens.source


@pytest.mark.parametrize("name", sorted(LENS))
@pytest.mark.parametrize("nm", [450.0, 650.0])
def test_every_ray_is_that_of_an_independent_tracer(name: str, nm: float) -> None:
    start, end = batch(LENS[name], nm)
    alive = 0
    for n in range(start.x.size):
        place = np.array([start.x[n], start.y[n], start.z[n]])
        way = np.array([start.dx[n], start.dy[n], start.dz[n]])
        found = independent_ray(LENS[name], place, way, nm)
        assert (found is not None) == bool(end.alive[n])
        if found is not None:
            alive += 1
            np.testing.assert_allclose([end.x[n], end.y[n], end.z[n]], found[0], atol=1e-12)
            np.testing.assert_allclose([end.dx[n], end.dy[n], end.dz[n]], found[1], atol=1e-11)
    assert 100 < alive < 300


@pytest.mark.parametrize("name", sorted(LENS))
def test_near_the_axis_it_is_paraxial(name: str) -> None:
    """The chart's scale, the place of the entrance pupil, and the light on the axis."""
    lens = LENS[name]
    body, scene = mounted(lens), in_chart(lens)
    known = real_field(scene)
    assert known is not None
    colour = np.isclose(WAVELENGTHS_NM, 600)
    # Tables are of 550 nm, paraxial figures of 587.56 nm: a hundredth of the dispersion.
    assert known.crossing_m[0] == pytest.approx(-body.entrance_pupil_m, rel=4e-3)
    scale = known.slope[1] * (lens.focus_distance_m - known.crossing_m[1]) / known.radius_m[1]
    assert scale * lens.image_distance_m / lens.focus_distance_m == pytest.approx(1, rel=3e-3)
    # A lens free of spherical aberration and coma fills sin = 1 / 2N: pi sin^2 instead of pi tan^2.
    tangent = body.exit_pupil_radius_m / (body.detector_m - body.exit_pupil_m)
    sine2 = tangent**2 / (1 + tangent**2)
    assert known.etendue[0, colour][0] / (np.pi * sine2) == pytest.approx(1, abs=0.05)


@pytest.mark.parametrize("name", sorted(LENS))
def test_distortion_and_illumination_are_those_of_independent_rays(name: str) -> None:
    """At seven tenths of the corner: the chief ray by a search with the independent tracer, and
    the open pupil counted on a grid with it."""
    lens = LENS[name]
    body, scene = mounted(lens), in_chart(lens)
    known = field(lens, corner_m(scene))
    index = int(np.searchsorted(known.radius_m, 0.7 * corner_m(scene)))
    radius = known.radius_m[index]
    reach = body.exit_pupil_m - body.detector_m

    def shoot(px: float, py: float) -> tuple[np.ndarray, np.ndarray] | None:
        way = np.array([px + radius, py, reach])
        way *= -np.sign(reach) / np.linalg.norm(way)
        return independent_ray(lens, np.array([-radius, 0.0, body.detector_m]), way, 550.0)

    side = np.linspace(-1.6, 1.6, 81) * body.exit_pupil_radius_m
    step = side[1] - side[0]
    total, spread = 0.0, 0
    for px in side:
        inside = [shoot(px + known.centre_m[index], py) is not None for py in side]
        for py, passes in zip(side, inside, strict=True):
            d2 = (px + known.centre_m[index] + radius) ** 2 + py**2 + reach**2
            total += passes * reach**2 / d2**2 * step**2
        spread += sum(a != b for a, b in pairwise(inside))
    found = np.interp(550.0, WAVELENGTHS_NM, known.etendue[index])
    # A grid counts the cells on an outline at random: half a cell each, averaging out.
    assert total == pytest.approx(
        found, rel=4 * 0.5 * np.sqrt(2 * spread) * step**2 / (found * reach**2)
    )
    chief = shoot(*chief_by_search(lens, radius))
    assert chief is not None
    place, way = chief
    slope = -way[0] / way[2]
    assert slope == pytest.approx(known.slope[index], rel=1e-6)
    height = place[0] + slope * (place[2] + 0.345)
    expected = (0.345 - known.crossing_m[index]) * known.slope[index]
    assert height == pytest.approx(expected, rel=1e-6)


def test_glass_bends_as_its_formula_says() -> None:
    """N-BK7 by Sellmeier and by Abbe number agree in the visible to 2e-4, and at d exactly."""
    schott = (1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653)
    by_sellmeier = Surface(thickness=1, rim=1, sellmeier=schott)
    by_abbe = Surface(thickness=1, rim=1, index=1.5168, abbe=64.17)
    assert by_sellmeier.index_at(np.array(D_NM)) == pytest.approx(1.5168, abs=1e-5)
    nm = np.linspace(430, 700, 50)
    np.testing.assert_allclose(by_abbe.index_at(nm), by_sellmeier.index_at(nm), atol=4e-4)


def test_an_asphere_focuses_where_a_sphere_does_not(tmp_path: Path) -> None:
    """A hyperboloid with k = -n^2 behind plane glass brings parallel light to one point, and so
    does the same surface written as a sphere and a power series."""
    n, radius = 1.5, 10.0
    focal = radius / (n - 1)
    series = _series_of_conic(1 / -radius, -(n**2))
    for how in (f"conic = {-(n**2)}", f"aspheric = {series}"):
        (tmp_path / "lens.toml").write_text(
            f'name = "a"\nsource = "-"\nfocal_length = {focal}\nsurface = [\n'
            f"{{ thickness = 3.0, rim = 3.0, index = {n} }},\n"
            f"{{ radius = {-radius}, thickness = 0.0, rim = 3.0, {how} }},\n"
            "{ thickness = 0.0, rim = 3.0, stop = true },\n]\n"
        )
        mounted.cache_clear()
        lens = Lens(
            kind="real",
            prescription=str(tmp_path / "lens.toml"),
            focal_length_mm=focal,
            f_number=5.0,
            focus_distance_m=1e6,
        )
        body = mounted(lens)
        aim = np.linspace(-1.5e-3, 1.5e-3, 9)
        back = -np.full(9, body.detector_m - body.vertex_m[-1])
        length = np.hypot(aim, back)
        start = Rays(
            x=0 * aim,
            y=0 * aim,
            z=np.full(9, body.detector_m),
            dx=aim / length,
            dy=0 * aim,
            dz=back / length,
            alive=np.ones(9, bool),
        )
        end = trace(body, start, body.indices(np.array([D_NM])))
        assert end.alive.all()
        # Parallel light: all slopes in the scene are 0.
        np.testing.assert_allclose(end.dx / end.dz, 0, atol=1e-7)


def _series_of_conic(curvature: float, conic: float) -> list[float]:
    """What a conic has beyond its sphere, in r^4, r^6, r^8, r^10, r^12."""
    from math import comb

    terms = []
    for order in range(2, 7):
        # The sagitta is the sum of C_m (1 + k)^(m-1) c^(2m-1) r^2m, C_m of Catalan's kind.
        factor = comb(2 * (order - 1), order - 1) / order / 2 ** (2 * order - 1)
        terms.append(factor * curvature ** (2 * order - 1) * ((1 + conic) ** (order - 1) - 1))
    return terms


def test_an_ideal_lens_is_the_thin_lens(tmp_path: Path) -> None:
    """An ideal surface behind its stop, at f/32: the same places and the same light. What is left
    is the thin lens's own neglect, the second order of the aperture: (a / v)^2 = 2.3e-4."""
    (tmp_path / "ideal.toml").write_text(IDEAL)
    thin = load("chart").with_size(*SIZE)
    lens = dataclasses.replace(thin.lens, barrel=None, f_number=32.0)
    thin = dataclasses.replace(thin, lens=lens)
    ideal = dataclasses.replace(
        thin,
        lens=dataclasses.replace(lens, kind="real", prescription=str(tmp_path / "ideal.toml")),
    )
    refuse_impossible(ideal)
    for name, where in panel_rectangles(thin).items():
        corner = where.left_m, where.top_m
        assert project(ideal, *corner) == pytest.approx(project(thin, *corner), abs=1e-3), name
    images = [closed_form.render(scene, "fluorescent") for scene in (thin, ideal)]
    if backend().jit:
        images.append(path_traced.render(ideal, "fluorescent", samples=32))
    for panel in panels(ideal):
        one, *others = (i.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float) for i in images)
        for other in others:
            np.testing.assert_allclose(other, one, rtol=3e-4)


@needs_jit
@pytest.mark.parametrize("name", sorted(LENS))
def test_inside_panels_it_is_the_closed_form(name: str) -> None:
    scene = in_chart(LENS[name])
    refuse_impossible(scene)
    image, truth = (how.render(scene, "fluorescent") for how in (path_traced, closed_form))
    assert len(image.header.panels) == 24
    assert max(image.header.noise.values()) < 1e-3
    for panel in image.header.panels:
        rate, true = (
            i.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float) for i in (image, truth)
        )
        # The tables are read between 33 radii and 7 wavelengths: 1e-4.
        np.testing.assert_allclose(rate, true, rtol=2e-4)


@needs_jit
def test_without_a_witness_it_is_the_same_light() -> None:
    """Nothing but traced rays and their weights, against the etendue of the tables."""
    scene = in_chart(LENS["speed-panchro"], (96, 72))
    plain = path_traced.render(scene, "incandescent", witness=False, samples=512)
    truth = closed_form.render(scene, "incandescent")
    limit = z_limit(3 * len(plain.header.panels))
    for panel in plain.header.panels:
        rate, true = (
            i.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float) for i in (plain, truth)
        )
        variance = plain.variance[panel.window].mean(axis=(0, 1), dtype=float)
        error = np.sqrt(variance / (panel.w * panel.h))
        assert (abs(rate - true) < limit * error + 3e-4 * true).all()


@needs_jit
def test_drawn_wavelengths_come_to_the_same() -> None:
    scene = in_chart(LENS["speed-panchro"], (96, 72))
    image = path_traced.render(scene, "incandescent", wavelengths="sampled", samples=288)
    truth = closed_form.render(scene, "incandescent")
    limit = z_limit(3 * len(image.header.panels))
    for panel in image.header.panels:
        rate, true = (
            i.rate_e_per_s[panel.window].mean(axis=(0, 1), dtype=float) for i in (image, truth)
        )
        variance = image.variance[panel.window].mean(axis=(0, 1), dtype=float)
        error = np.sqrt(variance / (panel.w * panel.h))
        assert (abs(rate - true) < limit * error + 5e-4 * true).all()


def test_the_scalar_backend_says_that_it_cannot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CHOICE_VARIABLE, "scalar")
    with pytest.raises(RenderError, match="real lens on the scalar backend"):
        path_traced.render(in_chart(LENS["flektagon"]), "fluorescent")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"prescription": "tesar"}, "unknown lens prescription 'tesar'"),
        ({"prescription": None}, "without prescription"),
        ({"kind": "thin"}, "'thin' with prescription"),
        ({"barrel": Barrel(radius_mm=3, distance_mm=2)}, "a real lens with a barrel"),
        ({"f_number": 0.7}, "f_number = 0.7 of lens 'Speed Panchro'; expected at least"),
        ({"focal_length_mm": 2.5}, "lights the detector to .* mm from its centre"),
        ({"focus_distance_m": 0.004}, "forms no image"),
    ],
)
def test_a_lens_that_cannot_be_is_refused(changes: dict[str, Any], message: str) -> None:
    lens = dataclasses.replace(LENS["speed-panchro"], **changes)
    with pytest.raises(SceneError, match=message):
        refuse_impossible(in_chart(lens))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ideal_focal_length = 4.3", "ideal_focal_length = -4.3", "no positive focal length"),
        (", stop = true", "", "has 0 stops"),
        ("rim = 1.75", "rim = -1.75", "above 0"),
        ("rim = 1.75", "rims = 1.75", r"unknown key 'surface\[0\].rims'"),
    ],
)
def test_a_prescription_that_cannot_be_is_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert old in IDEAL
    (tmp_path / "bad.toml").write_text(IDEAL.replace(old, new))
    lens = dataclasses.replace(LENS["flektagon"], prescription=str(tmp_path / "bad.toml"))
    mounted.cache_clear()
    with pytest.raises(InputError, match=message):
        refuse_impossible(in_chart(lens))


def test_two_lenses_come_with_the_package() -> None:
    assert prescription_names() == ["flektagon", "speed-panchro"]
