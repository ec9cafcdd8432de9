"""The oracle: the rate image of a matt plane under a point lamp, link by link in SI units.

    E(p)     = I cos(theta_lamp) / R^2               irradiance on the chart       [1], W/(m2 nm)
    L(p)     = rho E / pi                            radiance, Lambert             W/(m2 sr nm)
    H(q)     = L  T (A / v^2) cos^4(theta)  w(q)     irradiance on the detector    [2], W/(m2 nm)
    rate     = pitch^2 Integral H QE lambda/(h c) d lambda                         e-/s

A / v^2 is the solid angle of the aperture from the centre of the detector, as for a thin lens
seen along its chief ray; w is the part of the aperture that the barrel leaves open, the overlap
of two circles. Everything inside a panel is a matt plane, so defocus averages over a disc of 2 mm
in which nothing curves: E is taken at the centroid of what the barrel leaves of the disc, blurred
edges are left out, and this image is right inside panels only.

Spectra are linear between samples, so a product of three of them and the wavelength is a
polynomial of degree 4 in each cell, which three Gauss-Legendre points integrate exactly.

Nothing here is shared with the path tracer but the scene and its spectra: that is its use.

[1] R. W. Boyd, Radiometry and the Detection of Optical Radiation, Wiley 1983, ch. 2.
[2] W. J. Smith, Modern Optical Engineering, 4th ed., McGraw-Hill 2008, ch. 9.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from render.rate import RateHeader, RateImage, rate_image
from render.record import optics, versions
from scenes.geometry import panel_rectangles, panels
from scenes.lamps import emission
from scenes.scene import Lamp, Lens, Scene
from scenes.spectra import CHANNELS, Spectrum, reflectances, response

Array = NDArray[np.float64]

PLANCK_J_S = 6.62607015e-34
LIGHT_SPEED_M_PER_S = 299792458.0
GAUSS_POINT, GAUSS_WEIGHT = np.polynomial.legendre.leggauss(3)


def electrons_per_joule(quantum_efficiency: Array, nm: Array) -> Array:
    """Electrons for a joule of light: QE lambda / (h c)."""
    return quantum_efficiency * nm * 1e-9 / (PLANCK_J_S * LIGHT_SPEED_M_PER_S)


def spectral_integral(
    light: Spectrum, reflectance: Spectrum | float, quantum_response: Spectrum, peak: float
) -> float:
    """Integral of intensity x reflectance x electrons per joule: e-/(s sr)."""
    curves = [light, quantum_response]
    curves += [reflectance] if isinstance(reflectance, Spectrum) else []
    nodes = functools.reduce(np.union1d, [curve.nm for curve in curves])
    low, high = max(c.nm[0] for c in curves[:2]), min(c.nm[-1] for c in curves[:2])
    nodes = nodes[(nodes >= low) & (nodes <= high)]
    half, middle = np.diff(nodes)[:, None] / 2, (nodes[1:] + nodes[:-1])[:, None] / 2
    nm = middle + half * GAUSS_POINT
    reflected = reflectance.at(nm) if isinstance(reflectance, Spectrum) else reflectance
    integrand = light.at(nm) * reflected * electrons_per_joule(peak * quantum_response.at(nm), nm)
    return float((half * GAUSS_WEIGHT * integrand).sum())


def pixel_points(scene: Scene) -> tuple[Array, Array]:
    """Where the chief ray of each pixel's centre meets the chart: x (1, W) and y (H, 1) in m."""
    detector = scene.detector
    scale = detector.pitch_um * 1e-6 * scene.camera_distance_m / scene.lens.image_distance_m
    columns = np.arange(detector.width_px, dtype=np.float64) - (detector.width_px - 1) / 2
    rows = (detector.height_px - 1) / 2 - np.arange(detector.height_px, dtype=np.float64)
    return np.asarray(columns * scale)[None, :], np.asarray(rows * scale)[:, None]


def irradiance_factor(lamp: Lamp, x_m: Array, y_m: Array) -> Array:
    """cos(theta) / R^2 of a point lamp on the plane z = 0, in 1/m2."""
    lamp_x, lamp_y, lamp_z = lamp.position_m
    squared = (x_m - lamp_x) ** 2 + (y_m - lamp_y) ** 2 + lamp_z**2
    return np.asarray(lamp_z * squared**-1.5)


def natural_falloff(scene: Scene, x_m: Array, y_m: Array) -> Array:
    """cos^4 of the angle between the chief ray and the optical axis."""
    distance = scene.camera_distance_m
    return np.asarray((distance**2 / (distance**2 + x_m**2 + y_m**2)) ** 2)


def circle_overlap(radius_a: float, radius_b: float, separation: Array) -> tuple[Array, Array]:
    """Area common to two circles, and how far its centroid lies from A's centre towards B's.

    The common area is a segment of A and a segment of B on one chord. A segment's first moment
    about its own circle's centre is two thirds of the cube of half its chord, so those of the two
    cancel but for the separation times the segment of B.
    """
    a, b = radius_a, radius_b
    d = np.clip(separation, max(abs(a - b), 1e-12 * a), a + b)
    of_a = np.arccos(np.clip((d**2 + a**2 - b**2) / (2 * d * a), -1, 1))
    of_b = np.arccos(np.clip((d**2 + b**2 - a**2) / (2 * d * b), -1, 1))
    segment_a = a**2 * (of_a - np.sin(2 * of_a) / 2)
    segment_b = b**2 * (of_b - np.sin(2 * of_b) / 2)
    area = segment_a + segment_b
    centroid = np.divide(d * segment_b, area, out=np.zeros_like(d), where=area > 0)
    within = separation <= abs(a - b)
    area = np.where(within, np.pi * min(a, b) ** 2, area)
    return area, np.where(within, 0.0 if a <= b else separation, centroid)


def open_aperture(scene: Scene, x_m: Array, y_m: Array) -> tuple[Array, Array]:
    """The part of the aperture that the barrel leaves open for each pixel, and, on the chart,
    the factor by which the centroid of the light lies nearer to the optical axis.

    All rays of a pixel meet in its point of sharp focus F; through it the barrel's opening
    projects onto the aperture as a circle of radius r / (1 - z/u), shifted by -F (z/u) / (1 - z/u).
    A ray through the point a of the aperture meets the chart (1 - d/u) a off the chief ray.
    """
    lens: Lens = scene.lens
    radius = np.hypot(x_m, y_m)
    if lens.barrel is None:
        return np.ones_like(radius), np.ones_like(radius)
    near = lens.barrel.distance_mm * 1e-3 / lens.focus_distance_m
    beyond = scene.camera_distance_m / lens.focus_distance_m
    shift = radius / beyond * near / (1 - near)
    aperture = lens.aperture_radius_m
    shared, centroid = circle_overlap(aperture, lens.barrel.radius_mm * 1e-3 / (1 - near), shift)
    moved = np.divide((1 - beyond) * -centroid, radius, out=np.zeros_like(radius), where=radius > 0)
    return np.asarray(shared / (np.pi * aperture**2)), np.asarray(1 + moved)


def material_rates(
    scene: Scene, lamp: Lamp, response_curves: Mapping[str, Spectrum] | None = None
) -> Array:
    """Spectral integrals (26, 3) of the panels, then the card and the wall, in e-/(s sr)."""
    light, curves = emission(lamp), response_curves or response(scene.detector.response)
    materials: list[Spectrum | float] = [*reflectances(scene.chart.reflectances)]
    materials += [scene.chart.frame_reflectance, scene.surround_reflectance]
    peak = scene.detector.peak_quantum_efficiency
    return np.array(
        [[spectral_integral(light, m, curves[c], peak) for c in CHANNELS] for m in materials]
    )


def material_map(scene: Scene, x_m: Array, y_m: Array) -> NDArray[np.intp]:
    """Which material each pixel's chief ray meets: 0 to 23 the panels, 24 the card, 25 the wall."""
    half_width, half_height = scene.chart.width_m / 2, scene.chart.height_m / 2
    on_card = (np.abs(x_m) <= half_width) & (np.abs(y_m) <= half_height)
    result = np.where(on_card, 24, 25).astype(np.intp)
    for index, where in enumerate(panel_rectangles(scene).values()):
        columns = (where.left_m <= x_m) & (x_m <= where.right_m)
        rows = (where.bottom_m <= y_m) & (y_m <= where.top_m)
        result[columns & rows] = index
    return result


def render(
    scene: Scene, lamp: str | Lamp, *, response_curves: Mapping[str, Spectrum] | None = None
) -> RateImage:
    """The rate image by formula, without noise; right inside panels.

    `response_curves` are R, G, B in place of the scene's, relative to the same peak efficiency.

    Raises:
        SceneError: for a lamp that the scene does not have.
    """
    source = scene.named(lamp) if isinstance(lamp, str) else lamp
    x_m, y_m = pixel_points(scene)
    lens = scene.lens
    solid_angle_sr = np.pi * lens.aperture_radius_m**2 / lens.image_distance_m**2
    open_part, moved = open_aperture(scene, x_m, y_m)
    detector_factor = (
        lens.transmission
        * solid_angle_sr
        * natural_falloff(scene, x_m, y_m)
        * open_part
        * (scene.detector.pitch_um * 1e-6) ** 2
    )
    shading = irradiance_factor(source, x_m * moved, y_m * moved) / np.pi * detector_factor
    rates = material_rates(scene, source, response_curves)
    rate = rates[material_map(scene, x_m, y_m)] * shading[..., None]
    header = RateHeader(
        scene=scene.name,
        lamp=source.name,
        optics=optics(scene, "closed form"),
        versions=versions(),
        panels=panels(scene),
    )
    return rate_image(rate, np.zeros_like(rate), header)
