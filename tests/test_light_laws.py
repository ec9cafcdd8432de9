"""The laws that the closed-form renderer has to obey, each alone."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy import constants, integrate

from render import calibrate, closed_form, spectral
from render.pupil import open_fraction
from scenes.lamps import emission
from scenes.scene import Scene, load
from scenes.spectra import CHANNELS, reflectances, response, spectrum


@pytest.fixture(scope="module")
def chart() -> Scene:
    return load("chart")


def _without_barrel(scene: Scene) -> Scene:
    return dataclasses.replace(scene, lens=dataclasses.replace(scene.lens, barrel=None))


def test_irradiance_falls_with_the_square_of_the_distance(chart: Scene) -> None:
    zero = np.zeros(1)
    for distance in (0.3, 1.0, 7.0):
        lamp = dataclasses.replace(chart.lamp[0], position_m=(0.0, 0.0, distance))
        assert closed_form.irradiance_factor(lamp, zero, zero) == pytest.approx(distance**-2)


def test_a_plane_all_around_a_lamp_catches_half_its_light(chart: Scene) -> None:
    lamp = dataclasses.replace(chart.lamp[0], position_m=(0.0, 0.0, 0.5))

    def ring(radius: float) -> float:
        at = np.array([radius])
        return float(2 * np.pi * radius * closed_form.irradiance_factor(lamp, at, np.zeros(1))[0])

    caught, _ = integrate.quad(ring, 0, np.inf)
    assert caught == pytest.approx(2 * np.pi, rel=1e-8)


def test_natural_falloff_is_the_fourth_power_of_the_cosine() -> None:
    for degrees in (0, 10, 25, 45):
        falloff = closed_form.natural_falloff(np.array([math.tan(math.radians(degrees))]))
        assert falloff == pytest.approx(math.cos(math.radians(degrees)) ** 4)


def test_circles_overlap_as_counted_on_a_grid() -> None:
    step = 1 / 1500
    x, y = np.meshgrid(*[np.arange(-1 + step / 2, 1, step)] * 2)
    inside_a = x**2 + y**2 <= 1
    for radius, separation in ((1.3, 0.2), (1.3, 0.5), (1.3, 1.1), (1.3, 2.0), (2.0, 1.5)):
        both = inside_a & ((x - separation) ** 2 + y**2 <= radius**2)
        area, centroid = closed_form.circle_overlap(1.0, radius, np.array([separation]))
        # A pixel count along an edge of length L is off by about step^1.5 sqrt(L): 4e-5.
        assert area[0] == pytest.approx(both.sum() * step**2, abs=4e-4)
        assert centroid[0] == pytest.approx(x[both].mean(), abs=4e-4)


def test_two_ways_to_the_open_part_of_the_aperture_agree(chart: Scene) -> None:
    by_overlap, _ = closed_form.open_aperture(chart, closed_form.sight(chart).slope)
    by_slices = open_fraction(chart)
    np.testing.assert_allclose(by_slices, by_overlap, atol=1e-5)
    assert by_overlap.min() < 0.8
    assert by_overlap.max() == pytest.approx(1, abs=1e-12)
    assert (open_fraction(_without_barrel(chart)) == 1).all()


def test_one_pixel_by_hand(chart: Scene) -> None:
    """The whole chain for one pixel of panel 19, with monochromatic building blocks."""
    scene = _without_barrel(chart)
    lamp = scene.lamp[1]
    image = closed_form.render(scene, lamp)
    row, column = 400, 60
    lens, detector = scene.lens, scene.detector
    image_m = 1 / (1 / (lens.focal_length_mm / 1e3) - 1 / lens.focus_distance_m)
    u_m = (column + 0.5 - 320) * 5.6e-6
    v_m = (row + 0.5 - 240) * 5.6e-6
    x_m, y_m = (t * scene.camera_distance_m / image_m for t in (u_m, -v_m))
    to_lamp = np.array(lamp.position_m) - [x_m, y_m, 0]
    distance2 = to_lamp @ to_lamp
    cosine = to_lamp[2] / math.sqrt(distance2)
    fourth = math.cos(math.atan(math.hypot(u_m, v_m) / image_m)) ** 4
    aperture_m2 = math.pi * (lens.focal_length_mm / 1e3 / lens.f_number / 2) ** 2
    nm = np.arange(400, 700.0005, 0.001)
    light, white = emission(lamp), reflectances(str(scene.chart.reflectances))[18]
    for index, channel in enumerate(CHANNELS):
        radiance = light.at(nm) * cosine / distance2 * white.at(nm) / math.pi
        power = radiance * lens.transmission * aperture_m2 / image_m**2 * fourth * 5.6e-6**2
        photons = power * nm * 1e-9 / (constants.h * constants.c)
        efficiency = 0.4 * response(detector.response)[channel].at(nm)
        expected = np.trapezoid(photons * efficiency, nm)
        # 32-bit floats hold 6e-8, the sum over 0.001 nm leaves 1e-6 at the ends of the table.
        assert image.rate_e_per_s[row, column, index] == pytest.approx(expected, rel=3e-6)


def test_mercury_lines_are_integrated_exactly() -> None:
    line = spectrum([500, 505, 510], [0.0, 1.0, 0.0])
    flat = spectrum([400, 700], [1.0, 1.0])
    joule = constants.h * constants.c / 505e-9
    got = spectral.spectral_integral(line, 1.0, flat, 1.0)
    assert got == pytest.approx(5 / joule, rel=1e-12)


def test_light_is_linear_in_the_lamp(chart: Scene) -> None:
    lamp = chart.lamp[0]
    twice = dataclasses.replace(lamp, intensity_w_per_sr=2 * lamp.intensity_w_per_sr)
    one, two = (closed_form.render(chart, each).rate_e_per_s for each in (lamp, twice))
    np.testing.assert_allclose(two, 2 * one, rtol=3e-7)


def test_the_presets_lamps_are_adjusted_as_the_paper_says(chart: Scene) -> None:
    """Grey is equal in R, G and B within 0.1 %, at the assumed absolute scale."""
    for lamp in chart.lamp:
        rate = calibrate.panel_rate(chart, lamp, chart.calibration.panel)
        np.testing.assert_allclose(rate, chart.calibration.rate_e_per_s, rtol=1e-3)
        for panel in ("20", "21", "22", "23", "24"):
            grey = calibrate.panel_rate(chart, lamp, panel)
            assert np.ptp(grey) / grey.mean() < 0.1


def test_a_new_lamp_can_be_adjusted(chart: Scene) -> None:
    lamp = calibrate.adjusted(chart, dataclasses.replace(chart.lamp[0], spd="FL11", filter=None))
    rate = calibrate.panel_rate(chart, lamp, "19")
    np.testing.assert_allclose(rate, chart.calibration.rate_e_per_s, rtol=1e-5)
