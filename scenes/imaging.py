"""Which ray through the lens a point of the detector sees, and how far defocus spreads it.

A chief ray lies in a plane with the optical axis. It is told by where it crosses the axis on its
way to the chart, and by its slope there: of a thin lens always at the lens, with the slope of the
straight line through its centre; of a real lens at its entrance pupil, which may wander.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from scenes.field import Field, field

if TYPE_CHECKING:
    from scenes.scene import Scene

Array = NDArray[np.float64]


def corner_m(scene: Scene) -> float:
    """From the centre of the detector to its corner."""
    detector = scene.detector
    return math.hypot(detector.width_px, detector.height_px) * detector.pitch_um * 1e-6 / 2


def real_field(scene: Scene) -> Field | None:
    """The tables of a scene's real lens; none for a thin one."""
    return field(scene.lens, corner_m(scene)) if scene.lens.kind == "real" else None


def chief_rays(scene: Scene, radius_m: Array) -> tuple[Array, Array]:
    """For points of the detector at some distances from its centre: where the chief ray crosses
    the optical axis, as z in m before the chart, and its slope away from the axis.
    """
    known = real_field(scene)
    if known is None:
        crossing_m = np.full_like(radius_m, scene.camera_distance_m)
        return crossing_m, radius_m / scene.lens.image_distance_m
    ahead_m = smooth(known.radius_m, known.crossing_m, radius_m, odd=False)
    slope = smooth(known.radius_m, known.slope, radius_m, odd=True)
    return scene.camera_distance_m - ahead_m, slope


def smooth(radius_m: Array, values: Array, at_m: Array, *, odd: bool) -> Array:
    """A table against the image radius at other radii: a cubic spline through its mirror image."""
    sign = -1 if odd else 1
    both = np.concatenate([-radius_m[:0:-1], radius_m])
    mirrored = np.concatenate([sign * values[:0:-1], values])
    return np.asarray(CubicSpline(both, mirrored)(at_m))


def image_radius_m(scene: Scene, distance_m: float, z_m: float) -> float:
    """How far from the centre of the detector a point lies in the image, over its own distance
    from the optical axis; the point stands z before the plane of the chart.
    """
    known = real_field(scene)
    if known is None:
        return scene.lens.image_distance_m / (scene.camera_distance_m - z_m)
    fine_m = np.linspace(0.0, known.radius_m[-1], 4001)
    crossing_m, slope = chief_rays(scene, fine_m)
    reach_m = (crossing_m - z_m) * slope
    if distance_m < reach_m[1]:
        return float(fine_m[1] / reach_m[1])
    if distance_m > reach_m[-1]:  # out of the picture: by the scale of its corner
        return float(fine_m[-1] / reach_m[-1])
    return float(np.interp(distance_m, reach_m, fine_m)) / distance_m


def blur_diameter_px(scene: Scene, place_m: tuple[float, ...] = (0.0, 0.0, 0.0)) -> float:
    """Diameter of the disc into which defocus spreads a point in space, in px.

    Similar triangles behind a thin lens: 2 a v |1/u_focus - 1/u_point|. Of a real lens twice the
    distance of the farthest ray from the chief ray, whatever the aberration, and a pixel more.
    """
    lens, pitch_m = scene.lens, scene.detector.pitch_um * 1e-6
    distance_m = scene.camera_distance_m - place_m[2]
    known = real_field(scene)
    if known is None:
        vergence = abs(1 / lens.focus_distance_m - 1 / distance_m)
        return 2 * lens.aperture_radius_m * lens.image_distance_m * vergence / pitch_m
    aside_m = math.hypot(place_m[0], place_m[1])
    radius_m = image_radius_m(scene, aside_m, place_m[2]) * aside_m
    spread_m = float(np.interp(radius_m, known.radius_m, known.blur_m(distance_m)))
    return 2 * spread_m * lens.image_distance_m / distance_m / pitch_m + 1


def edge_margin_px(scene: Scene, place_m: tuple[float, ...]) -> float:
    """How far from an edge the image is clear of it: a blur diameter of a thin lens; of a real
    lens, whose tables hold the farthest ray, six tenths of it.
    """
    return blur_diameter_px(scene, place_m) * (0.6 if scene.lens.kind == "real" else 1.0)


def largest_slope(scene: Scene) -> float:
    """The slope of the chief ray of a corner of the image."""
    return float(chief_rays(scene, np.array([corner_m(scene)]))[1][0])
