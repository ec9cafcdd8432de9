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

if TYPE_CHECKING:
    from scenes.scene import Scene

Array = NDArray[np.float64]


def chief_rays(scene: Scene, radius_m: Array) -> tuple[Array, Array]:
    """For points of the detector at some distances from its centre: where the chief ray crosses
    the optical axis, as z in m before the chart, and its slope away from the axis.
    """
    crossing_m = np.full_like(radius_m, scene.camera_distance_m)
    return crossing_m, radius_m / scene.lens.image_distance_m


def image_radius_m(scene: Scene, distance_m: float, z_m: float) -> float:
    """How far from the centre of the detector a point lies in the image, over its own distance
    from the optical axis; the point stands z before the plane of the chart.
    """
    return scene.lens.image_distance_m / (scene.camera_distance_m - z_m)


def blur_diameter_px(scene: Scene, place_m: tuple[float, ...] = (0.0, 0.0, 0.0)) -> float:
    """Diameter of the disc into which defocus spreads a point in space, in px.

    Similar triangles behind a thin lens: 2 a v |1/u_focus - 1/u_point|.
    """
    lens = scene.lens
    vergence = abs(1 / lens.focus_distance_m - 1 / (scene.camera_distance_m - place_m[2]))
    blur_m = 2 * lens.aperture_radius_m * lens.image_distance_m * vergence
    return blur_m / (scene.detector.pitch_um * 1e-6)


def largest_slope(scene: Scene) -> float:
    """The slope of the chief ray of a corner of the image."""
    detector = scene.detector
    corner_m = math.hypot(detector.width_px, detector.height_px) * detector.pitch_um * 1e-6 / 2
    return float(chief_rays(scene, np.array([corner_m]))[1][0])
