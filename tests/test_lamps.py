"""Lamps: a black body, a disk, a tube and a measured distribution, each by what is known of it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import constants

from foundation.backend import CHOICE_VARIABLE, probe
from render import closed_form, path_traced
from render.rate import RateImage
from render.together import together
from scenes.check import refuse_impossible
from scenes.errors import SceneError
from scenes.lamp import Lamp
from scenes.lamps import bare_spectrum, planck, relative_intensity
from scenes.photometry import read_ies
from scenes.scene import Scene, load
from tests.harness import assert_agree

HERE = (-0.06, 0.40, 0.45)
SQUARE = np.array([[0.0, 0.0], [0.1, -0.05], [-0.13, 0.09]])
"""Points of the chart, x and y in m."""

DISK = Lamp(
    name="disk",
    kind="disk",
    spd="A",
    position_m=HERE,
    intensity_w_per_sr=1.0,
    diameter_m=0.1,
)
TUBE = Lamp(
    name="tube", kind="tube", spd="FL2", position_m=HERE, intensity_w_per_sr=1.0, length_m=0.3
)

HEAD = "IESNA:LM-63-2002\n[TEST] figures made up for a test\nTILT=NONE\n"
STREET = HEAD + "1 1000 1 3 2 1 2 0 0 0\n1 1 50\n0 45 90\n0 90\n100 80 0\n100 40 0\n"


@pytest.fixture(scope="module")
def chart() -> Scene:
    return load("chart").with_size(160, 120)


def _factor(lamp: Lamp, points: np.ndarray = SQUARE) -> np.ndarray:
    return closed_form.irradiance_factor(lamp, points[:, 0], points[:, 1])


def test_a_black_body_follows_planck() -> None:
    """Stefan-Boltzmann and Wien, by quadrature of the law itself, and CIE illuminant A."""
    nm = np.linspace(50, 200_000, 2_000_001)
    per_nm = 2 * constants.h * constants.c**2 / (560e-9) ** 5 * 1e-9
    total = np.trapezoid(planck(2856.0, nm), nm) * per_nm * np.pi
    # What lies beyond 0.2 mm is 2e-7 of it, by the Rayleigh-Jeans law.
    assert total == pytest.approx(constants.sigma * 2856.0**4, rel=1e-6)
    peak = nm[planck(2856.0, nm).argmax()]
    assert peak * 1e-9 * 2856.0 == pytest.approx(constants.Wien, rel=1e-4)
    # CIE 15: A is Planck's law with c2 = 0.01435 m K and 2848 K, tabulated to 6 digits.
    kelvin = 2848.0 * constants.physical_constants["second radiation constant"][0] / 0.01435
    made = bare_spectrum(dataclasses.replace(DISK, spd=None, temperature_k=kelvin))
    table = bare_spectrum(DISK)
    np.testing.assert_allclose(made.at(table.nm[16:90]), table.value[16:90], rtol=3e-5)


def test_a_disk_is_the_view_factor_of_a_parallel_disk() -> None:
    """F = (1 - (h2 + d2 - a2) / sqrt((h2 + d2 + a2)2 - 4 a2 d2)) / 2, E = pi L F."""
    for height, radius in ((0.5, 0.05), (0.3, 0.1), (0.4, 0.2)):
        lamp = dataclasses.replace(
            DISK, position_m=(0.0, 0.0, height), diameter_m=2 * radius, aim_m=(0.0, 0.0, 0.0)
        )
        aside = np.array([0.0, 0.07, 0.2])
        found = _factor(lamp, np.stack([aside * 0.6, aside * 0.8], axis=1))
        reach = height**2 + aside**2
        root = np.sqrt((reach + radius**2) ** 2 - 4 * radius**2 * aside**2)
        exact = np.pi * (1 - (reach - radius**2) / root) / 2 / (np.pi * radius**2)
        np.testing.assert_allclose(found, exact, rtol=1e-5)


def test_a_tube_is_the_integral_over_its_length() -> None:
    """E = I cos(beta) / (l R) [alpha / 2 + sin(2 alpha) / 4] between the ends, alpha from the foot
    of the perpendicular R, beta between that and the normal of the chart."""
    length = TUBE.length_m or 0.0
    for (x, y), found in zip(SQUARE, _factor(TUBE), strict=True):
        across = np.hypot(HERE[1] - y, HERE[2])
        ends = np.arctan((HERE[0] - x + np.array([-length / 2, length / 2])) / across)
        inner = np.diff(ends / 2 + np.sin(2 * ends) / 4)[0]
        assert found == pytest.approx(HERE[2] / across / (length * across) * inner, rel=1e-9)


def test_what_a_thin_tube_neglects_of_a_thick_one() -> None:
    """A matt tube 16 mm thick, integrated over its lit side, against its axis: level and shape."""
    radius, length = 0.008, TUBE.length_m or 0.0

    angle = (np.arange(720) + 0.5) * np.pi / 360
    s = ((np.arange(200) + 0.5) / 200 - 0.5) * length
    normal = np.stack([np.zeros(720), np.cos(angle), np.sin(angle)], axis=1)[:, None]
    at = np.array(HERE) + radius * normal + s[:, None] * np.array([1.0, 0.0, 0.0])

    def thick(x: float, y: float) -> float:
        """Radiance 1 / (2 r l), cosines at both ends, over the surface of the tube."""
        way = np.array([x, y, 0.0]) - at
        r2 = (way**2).sum(axis=-1)
        seen = np.maximum((normal * way).sum(axis=-1), 0.0) * at[..., 2] / r2**2
        return float(seen.mean() * 2 * np.pi * radius * length / (2 * radius * length))

    ratio = np.array([thick(*point) for point in SQUARE]) / _factor(TUBE)
    # The figures of docs/light.md: a level that the calibration takes up, and a shape.
    assert ((ratio > 1.005) & (ratio < 1.012)).all()
    assert np.ptp(ratio) < 3e-3


def test_small_lamps_are_points() -> None:
    point = _factor(dataclasses.replace(DISK, kind="point", diameter_m=None))
    facing = np.array(HERE) / np.linalg.norm(HERE)
    away = np.array(HERE) - np.column_stack([SQUARE, np.zeros(3)])
    cosine = away @ facing / np.linalg.norm(away, axis=1)
    small = _factor(dataclasses.replace(DISK, diameter_m=1e-4))
    np.testing.assert_allclose(small, point * cosine, rtol=1e-6)
    short = _factor(dataclasses.replace(TUBE, length_m=1e-4))
    sine = np.sqrt(1 - (away[:, 0] / np.linalg.norm(away, axis=1)) ** 2)
    np.testing.assert_allclose(short, point * sine, rtol=1e-6)


def test_an_ies_file_is_read_and_mirrored_into_its_quadrants(tmp_path: Path) -> None:
    (tmp_path / "street.ies").write_text(STREET)
    found = read_ies(str(tmp_path / "street.ies"))
    np.testing.assert_allclose(found.at([0, 45, 90, 22.5, 95], 0), [1, 0.8, 0, 0.9, 0])
    for horizontal in (90, 270, -90):
        assert found.at(45, horizontal) == pytest.approx(0.4)
    for horizontal in (45, 135, 225, 315):
        assert found.at(45, horizontal) == pytest.approx(0.6)
    lamp = dataclasses.replace(
        DISK, kind="point", diameter_m=None, ies=str(tmp_path / "street.ies")
    )
    towards = -np.array(HERE) / np.linalg.norm(HERE)
    assert relative_intensity(lamp, towards[None, :]) == pytest.approx(1.0)


def test_an_ies_file_of_revolution_by_hand(tmp_path: Path) -> None:
    """A lamp that shines as the cosine, measured every degree, is a small disk."""
    degrees = np.arange(91)
    rows = " ".join(f"{c:.9f}" for c in np.cos(np.radians(degrees)))
    angles = " ".join(map(str, degrees))
    (tmp_path / "matt.ies").write_text(f"{HEAD}1 -1 1 91 1 1 2 0 0 0\n1 1 9\n{angles}\n0\n{rows}\n")
    lamp = dataclasses.replace(DISK, kind="point", diameter_m=None, ies=str(tmp_path / "matt.ies"))
    small = dataclasses.replace(DISK, diameter_m=1e-4)
    # Linear between degrees: 4e-5 of the curvature of a cosine.
    np.testing.assert_allclose(_factor(lamp), _factor(small), rtol=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("TILT=NONE", "TILT=INCLUDE", "expected TILT=NONE"),
        ("TILT=NONE\n", "", "no line 'TILT='"),
        ("1 1000 1 3 2 1 2", "1 1000 1 3 2 2 2", "photometry of type 2"),
        ("100 40 0\n", "100 40\n", "10 numbers after the head"),
        ("100 80 0", "100 -80 0", "negative"),
        ("100 80 0", "100 nan 0", "negative, all zero or no numbers"),
        ("0 45 90", "0 90 45", "do not rise"),
        ("\n0 90\n", "\n0 80\n", "horizontal angles"),
        ("1 1 50", "1 1 fifty", "could not convert"),
    ],
)
def test_a_bad_ies_file_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in STREET
    (tmp_path / "bad.ies").write_text(STREET.replace(old, new))
    with pytest.raises(SceneError, match=message) as caught:
        read_ies(str(tmp_path / "bad.ies"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"spd": None}, "neither spd and temperature_k"),
        ({"temperature_k": 3000.0}, "both spd and temperature_k"),
        ({"diameter_m": None}, "'disk' without diameter_m"),
        ({"length_m": 0.2}, "'disk' with length_m"),
        ({"kind": "point"}, "'point' with diameter_m"),
        ({"ies": "lamp.ies"}, "'disk' with ies"),
        ({"aim_m": HERE}, "points nowhere"),
        ({"kind": "tube", "diameter_m": None, "length_m": 0.2, "axis": (0, 0, 0)}, "nowhere"),
        ({"kind": "tube", "diameter_m": None, "length_m": 2.0, "axis": (0, 0, 1)}, "not before"),
        ({"diameter_m": 0.7}, "mirrored into the lens"),
    ],
)
def test_a_lamp_that_cannot_be_is_refused(
    chart: Scene, changes: dict[str, Any], message: str
) -> None:
    lamp = dataclasses.replace(DISK, **changes)
    with pytest.raises(SceneError, match=message):
        refuse_impossible(dataclasses.replace(chart, lamp=(lamp,)))


def _street(folder: Path) -> Lamp:
    (folder / "street.ies").write_text(STREET)
    return dataclasses.replace(
        DISK, name="street", kind="point", diameter_m=None, ies=str(folder / "street.ies")
    )


KINDS = ("disk", "large disk", "tube", "ies")


def _traced(
    kind: str, backend_name: str, size: tuple[int, int], folder: Path, patch: pytest.MonkeyPatch
) -> tuple[RateImage, RateImage]:
    """The traced image of a lamp, and the closed form."""
    if not probe(backend_name).works:  # type: ignore[arg-type]
        pytest.skip(f"backend {backend_name} does not work here")
    patch.setenv(CHOICE_VARIABLE, backend_name)
    lamp = {
        "disk": DISK,
        "large disk": dataclasses.replace(DISK, diameter_m=0.3),
        "tube": TUBE,
        "ies": _street(folder),
    }[kind]
    scene = dataclasses.replace(load("chart").with_size(*size), lamp=(lamp,))
    refuse_impossible(scene)
    return path_traced.render(scene, lamp, seed=3), closed_form.render(scene, lamp)


@pytest.mark.parametrize("kind", KINDS)
def test_traced_lamps_are_the_closed_form(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every pixel inside panels within 0.2 %; panel means within 1e-4, which is what pictures of
    512 pixels and 9 points leave. A lamp of some size makes no more noise than a point."""
    image, truth = _traced(kind, "llvm", (160, 120), tmp_path, monkeypatch)
    assert max(image.header.noise.values()) < 3e-4
    for panel in image.header.panels:
        rate, true = (i.rate_e_per_s[panel.window].astype(float) for i in (image, truth))
        np.testing.assert_allclose(rate, true, rtol=2e-3)
        np.testing.assert_allclose(rate.mean(axis=(0, 1)) / true.mean(axis=(0, 1)), 1, atol=1e-4)


@pytest.mark.parametrize("kind", ["disk", "tube", "ies"])
def test_without_jit_they_are_too_with_more_noise(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each path asks one point of the lamp there: panel means within the stated error."""
    image, truth = _traced(kind, "scalar", (96, 72), tmp_path, monkeypatch)
    rows = [
        (
            image.rate_e_per_s[p.window].mean(axis=(0, 1), dtype=float),
            truth.rate_e_per_s[p.window].mean(axis=(0, 1), dtype=float),
            np.sqrt(image.variance[p.window].mean(axis=(0, 1), dtype=float) / (p.w * p.h)),
        )
        for p in image.header.panels
    ]
    rate, true, error = np.array(rows).transpose(1, 0, 2)
    # The variance of so many pixels is known; 1e-4 is left by pictures and points, as above.
    assert_agree(rate, true, error + 1e-4 * true, f"{kind} on scalar")


def test_lamps_together_are_the_sum(chart: Scene) -> None:
    images = {name: closed_form.render(chart, name) for name in chart.lamp_names}
    both = together(images, {"incandescent": 1.0, "fluorescent": 0.25})
    parts = [images[name].rate_e_per_s for name in chart.lamp_names]
    np.testing.assert_allclose(both.rate_e_per_s, parts[0] + 0.25 * parts[1], rtol=1e-6)
    assert both.header.lamp == "incandescent+fluorescent"


def test_lamps_together_add_their_variances(chart: Scene) -> None:
    small = chart.with_size(64, 48)
    images = {n: path_traced.render(small, n, samples=8) for n in chart.lamp_names}
    both = together(images, {"incandescent": 2.0, "fluorescent": 1.0})
    parts = [images[name].variance for name in chart.lamp_names]
    np.testing.assert_allclose(both.variance, 4 * parts[0] + parts[1], rtol=1e-5)
