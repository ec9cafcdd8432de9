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

The integral over the wavelength is that of `spectral`. Nothing here is shared with the path tracer
but the scene and its spectra: that is its use.

[1] R. W. Boyd, Radiometry and the Detection of Optical Radiation, Wiley 1983, ch. 2.
[2] W. J. Smith, Modern Optical Engineering, 4th ed., McGraw-Hill 2008, ch. 9.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render import coat
from render.rate import RateHeader, RateImage, rate_image
from render.record import optics, versions
from render.spectral import channel_weights, material_rates, white_rates
from scenes.field import WAVELENGTHS_NM, Field
from scenes.geometry import panels, turn
from scenes.imaging import chief_rays, real_field, smooth
from scenes.lamp import Lamp
from scenes.lamps import axes, relative_intensity
from scenes.lens import Lens
from scenes.patches import patches
from scenes.scene import Scene
from scenes.spectra import Spectrum, response

Array = NDArray[np.float64]

TUBE_POINTS, DISK_RINGS, DISK_SPOKES = 16, 5, 12
UP = np.array([0.0, 0.0, 1.0])
"""The direction that an upright chart faces."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sight:
    """What each pixel looks at, arrays that broadcast to (H, W).

    Attributes:
        radius_m: distance of the pixel from the centre of the detector.
        slope: of its chief ray.
        x_m, y_m, z_m: where that meets the plane of the chart, in space.
        card_x_m, card_y_m: the same on the card, which may be tilted.
    """

    radius_m: Array
    slope: Array
    x_m: Array
    y_m: Array
    z_m: Array
    card_x_m: Array
    card_y_m: Array


def sight(scene: Scene) -> Sight:
    """Where the chief ray of each pixel's centre meets the plane of the chart."""
    detector = scene.detector
    pitch_m = detector.pitch_um * 1e-6
    u_m = ((np.arange(detector.width_px) - (detector.width_px - 1) / 2) * pitch_m)[None, :]
    v_m = (((detector.height_px - 1) / 2 - np.arange(detector.height_px)) * pitch_m)[:, None]
    radius_m = np.hypot(u_m, v_m)
    crossing_m, slope = chief_rays(scene, radius_m)
    # The slope over the radius is smooth where the radius is 0.
    per_m = np.divide(slope, radius_m, out=np.full_like(slope, np.nan), where=radius_m > 0)
    per_m = np.where(radius_m > 0, per_m, 1 / scene.lens.image_distance_m)
    to_space = turn(scene)
    facing = to_space[:, 2]
    reach_m = crossing_m * facing[2] / (facing[2] - per_m * (facing[0] * u_m + facing[1] * v_m))
    x_m, y_m = per_m * u_m * reach_m, per_m * v_m * reach_m
    z_m = crossing_m - reach_m
    return Sight(
        radius_m=radius_m,
        slope=slope,
        x_m=x_m,
        y_m=y_m,
        z_m=z_m,
        card_x_m=to_space[0, 0] * x_m + to_space[1, 0] * y_m + to_space[2, 0] * z_m,
        card_y_m=to_space[0, 1] * x_m + to_space[1, 1] * y_m + to_space[2, 1] * z_m,
    )


def lamp_points(lamp: Lamp) -> tuple[Array, Array]:
    """Points of a lamp (Q, 3) in m and their weights (Q,), which sum to 1, for quadrature.

    Gauss-Legendre along a tube and in the squared radius of a disk, even steps around it: what a
    point as near as a lamp's own diameter sees of it is then right to 1e-5.
    """
    middle = np.array(lamp.position_m)
    if lamp.kind == "tube":
        assert lamp.length_m is not None
        at, weight = np.polynomial.legendre.leggauss(TUBE_POINTS)
        along = np.array(lamp.axis) / np.linalg.norm(lamp.axis)
        return middle + np.outer(at * lamp.length_m / 2, along), weight / 2
    if lamp.kind == "disk":
        assert lamp.diameter_m is not None
        at, weight = np.polynomial.legendre.leggauss(DISK_RINGS)
        radius_m = lamp.diameter_m / 2 * np.sqrt((at + 1) / 2)
        angle = (np.arange(DISK_SPOKES) + 0.5) * 2 * np.pi / DISK_SPOKES
        x_m, y_m = (np.outer(radius_m, way(angle)).ravel() for way in (np.cos, np.sin))
        weights = np.repeat(weight / 2 / DISK_SPOKES, DISK_SPOKES)
        return middle + np.stack([x_m, y_m], axis=1) @ axes(lamp)[:2], weights
    return middle[None, :], np.ones(1)


def irradiance_factor(
    lamp: Lamp, x_m: Array, y_m: Array, z_m: Array | float = 0.0, facing: Array = UP
) -> Array:
    """Irradiance over intensity at points of a surface, in 1/m2: cos(theta) / R^2 of a point.

    Of a lamp of some size the mean of that over the lamp, each part weighted by how it shines in
    that direction.
    """
    total: Array = np.zeros(np.broadcast_shapes(np.shape(x_m), np.shape(y_m), np.shape(z_m)))
    for point, weight in zip(*lamp_points(lamp), strict=True):
        away = (x_m - point[0], y_m - point[1], z_m - point[2])
        squared = away[0] ** 2 + away[1] ** 2 + away[2] ** 2
        cosine = -(away[0] * facing[0] + away[1] * facing[1] + away[2] * facing[2])
        shining: Array | float = 1.0
        if lamp.kind != "point" or lamp.ies is not None:
            directions = np.stack(np.broadcast_arrays(*away), axis=-1)
            shining = relative_intensity(lamp, directions / np.sqrt(squared)[..., None])
        total = total + weight * shining * np.maximum(cosine, 0.0) * squared**-1.5
    return total


def natural_falloff(slope: Array) -> Array:
    """cos^4 of the angle between the chief ray and the optical axis, from its slope."""
    return np.asarray((1 + slope**2) ** -2)


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


def open_aperture(scene: Scene, slope: Array, z_m: Array | float = 0.0) -> tuple[Array, Array]:
    """The part of the aperture that the barrel leaves open for each pixel, and, on the chart,
    the factor by which the centroid of the light lies nearer to the optical axis.

    All rays of a pixel meet in its point of sharp focus F; through it the barrel's opening
    projects onto the aperture as a circle of radius r / (1 - z/u), shifted by -F (z/u) / (1 - z/u).
    A ray through the point a of the aperture meets the chart (1 - d/u) a off the chief ray.
    """
    lens: Lens = scene.lens
    if lens.barrel is None:
        return np.ones_like(slope), np.ones_like(slope)
    near = lens.barrel.distance_mm * 1e-3 / lens.focus_distance_m
    distance_m = scene.camera_distance_m - z_m
    beyond = distance_m / lens.focus_distance_m
    shift = slope * lens.focus_distance_m * near / (1 - near)
    aperture = lens.aperture_radius_m
    shared, centroid = circle_overlap(aperture, lens.barrel.radius_mm * 1e-3 / (1 - near), shift)
    radius = slope * distance_m
    moved = np.divide((1 - beyond) * -centroid, radius, out=np.zeros_like(radius), where=radius > 0)
    return np.asarray(shared / (np.pi * aperture**2)), np.asarray(1 + moved)


def material_map(scene: Scene, seen: Sight) -> NDArray[np.intp]:
    """Which material each pixel's chief ray meets, by its place in `material_rates`."""
    x_m, y_m = np.broadcast_arrays(seen.card_x_m, seen.card_y_m)
    half_width, half_height = scene.chart.width_m / 2, scene.chart.height_m / 2
    known = patches(scene.chart)
    on_card = (np.abs(x_m) <= half_width) & (np.abs(y_m) <= half_height)
    result = np.where(on_card, len(known), len(known) + 1).astype(np.intp)
    for index, patch in enumerate(known):
        angle = np.radians(patch.angle_deg)
        across, up = x_m - patch.x_m, y_m - patch.y_m
        if angle:
            turned = across * np.cos(angle) - up * np.sin(angle)
            across, up = turned, across * np.sin(angle) + up * np.cos(angle)
        inside = (np.abs(across) <= patch.half_width_m) & (np.abs(up) <= patch.half_height_m)
        result[inside] = index
    return result


def surface(scene: Scene, lamp: Lamp, seen: Sight) -> tuple[Array | float, Array | float]:
    """What a coat leaves of the matt colour, as a factor, and the lamp's highlight: radiance
    over intensity in 1/m2. Without a coat 1 and 0.
    """
    gloss = scene.chart.gloss
    if gloss is None:
        return 1.0, 0.0
    facing = turn(scene)[:, 2]
    place = np.stack(np.broadcast_arrays(seen.x_m, seen.y_m, seen.z_m), axis=-1)
    to_lens = np.array([0.0, 0.0, scene.camera_distance_m]) - place
    to_lens /= np.linalg.norm(to_lens, axis=-1, keepdims=True)
    matt: Array = np.zeros(place.shape[:-1])
    shine: Array = np.zeros(place.shape[:-1])
    total: Array = np.zeros(place.shape[:-1])
    for point, weight in zip(*lamp_points(lamp), strict=True):
        to_lamp = point - place
        far2 = (to_lamp**2).sum(axis=-1)
        to_lamp /= np.sqrt(far2)[..., None]
        falls = weight * relative_intensity(lamp, -to_lamp) * (to_lamp @ facing) / far2
        matt += falls * coat.below(to_lamp @ facing, to_lens @ facing, gloss)
        shine += falls * coat.highlight(to_lamp, to_lens, facing, gloss)
        total += falls
    return matt / total, shine


def detector_factor(scene: Scene, seen: Sight, weights: Array | None = None) -> tuple[Array, Array]:
    """From radiance to power on a pixel in m2 sr, and where the centroid of its light lies.

    (H, W); of a real lens (H, W, 3) for the light that each channel sees, with weights (3, W) of
    the wavelengths of `field.WAVELENGTHS_NM`, or (H, W, 1) with equal ones.
    """
    lens = scene.lens
    known = real_field(scene)
    if known is not None:
        return _real_factor(scene, seen, known, weights)
    solid_angle_sr = np.pi * lens.aperture_radius_m**2 / lens.image_distance_m**2
    open_part, moved = open_aperture(scene, seen.slope, seen.z_m)
    pixel_m2 = (scene.detector.pitch_um * 1e-6) ** 2
    power = lens.transmission * solid_angle_sr * natural_falloff(seen.slope) * open_part * pixel_m2
    return power, moved


def _real_factor(
    scene: Scene, seen: Sight, known: Field, weights: Array | None
) -> tuple[Array, Array]:
    """From radiance to power on a pixel in m2 sr, and where the centroid of its light lies, by the
    traced tables of a real lens: both (H, W, 3), or (H, W, 1) without weights.
    """
    even = np.full((1, WAVELENGTHS_NM.size), 1 / WAVELENGTHS_NM.size)
    pixel_m2 = (scene.detector.pitch_um * 1e-6) ** 2
    chief = (scene.camera_distance_m - known.crossing_m) * known.slope
    power, moved = [], []
    for share in even if weights is None else weights:
        etendue = smooth(known.radius_m, known.etendue @ share, seen.radius_m, odd=False)
        power.append(scene.lens.transmission * pixel_m2 * etendue)
        middle = known.centroid_m(scene.camera_distance_m, share)
        ratio = np.divide(middle, chief, out=np.ones_like(chief), where=known.radius_m > 0)
        ratio[0] = (4 * ratio[1] - ratio[2]) / 3
        moved.append(smooth(known.radius_m, ratio, seen.radius_m, odd=False))
    return np.stack(power, axis=-1), np.stack(moved, axis=-1)


def render(
    scene: Scene, lamp: str | Lamp, *, response_curves: Mapping[str, Spectrum] | None = None
) -> RateImage:
    """The rate image by formula, without noise; right inside panels.

    `response_curves` are R, G, B in place of the scene's, relative to the same peak efficiency.

    Raises:
        SceneError: for a lamp that the scene does not have.
    """
    source = scene.named(lamp) if isinstance(lamp, str) else lamp
    seen = sight(scene)
    curves = response_curves or response(scene.detector.response, scene.detector.infrared_cut)
    weights = channel_weights(source, curves, WAVELENGTHS_NM)
    power, moved = detector_factor(scene, seen, weights)
    if power.ndim == 2:
        power, moved = power[..., None], moved[..., None]
    facing = turn(scene)[:, 2]
    lit = np.stack(
        [
            irradiance_factor(source, seen.x_m * part, seen.y_m * part, seen.z_m, facing)
            for part in np.moveaxis(moved, -1, 0)
        ],
        axis=-1,
    )
    rates, where = material_rates(scene, source, response_curves), material_map(scene, seen)
    matt, shine = surface(scene, source, seen)
    on_panel = where < len(patches(scene.chart))
    shading = lit / np.pi * np.where(on_panel, matt, 1.0)[..., None] * power
    rate = rates[where] * shading
    if scene.chart.gloss is not None:
        mirrored = np.where(on_panel, shine, 0.0)[..., None] * power
        rate = rate + mirrored * white_rates(scene, source, response_curves)
    header = RateHeader(
        scene=scene.name,
        lamp=source.name,
        optics=optics(scene, "closed form"),
        versions=versions(),
        panels=panels(scene),
    )
    return rate_image(rate, np.zeros_like(rate), header)
