"""Light thrown back on the chart by a booth, once: the integral over its table and walls.

    E1(p) = Sum_w  rho / pi  E0(w) cos_w cos_p / r^2 dA

A flat chart sees neither itself nor the wall it hangs on, so table and side walls are all there is
for the first bounce.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.closed_form import UP, irradiance_factor
from render.rate import RateImage
from scenes.lamp import Lamp
from scenes.scene import Scene

Array = NDArray[np.float64]

GREEN = 1
NODES = 40
"""Gaussian nodes along each side of the table and the walls: right to 1e-6 a panel away."""


def bounced_factor(scene: Scene, lamp: Lamp, x_m: Array, y_m: Array) -> Array:
    """Irradiance over intensity, in 1/m2, after one bounce in the booth; of an upright chart."""
    total: Array = np.zeros(np.broadcast_shapes(x_m.shape, y_m.shape))
    booth = scene.booth
    if booth is None:
        return total
    at, weight = np.polynomial.legendre.leggauss(NODES)
    unit, share = (at + 1) / 2, weight / 2
    for origin, u, v, facing in _sides(scene):
        points = origin + unit[:, None, None] * u + unit[None, :, None] * v
        area = np.outer(share, share) * np.linalg.norm(np.cross(u, v))
        lit = irradiance_factor(lamp, points[..., 0], points[..., 1], points[..., 2], facing)
        for point, weighed in zip(
            points.reshape(-1, 3), (lit * area * booth.reflectance / np.pi).ravel(), strict=True
        ):
            away = x_m - point[0], y_m - point[1], -point[2]
            squared = away[0] ** 2 + away[1] ** 2 + away[2] ** 2
            leaving = away[0] * facing[0] + away[1] * facing[1] + away[2] * facing[2]
            arriving = -away[2] * UP[2]
            total = total + weighed * np.maximum(leaving, 0) * max(arriving, 0) / squared**2
    return total


def _sides(scene: Scene) -> list[tuple[Array, Array, Array, Array]]:
    """Table and walls: a corner, two sides, and the direction they face."""
    booth = scene.booth
    assert booth is not None
    x, y, z = np.eye(3)
    half, low = booth.width_m / 2, -booth.floor_m
    depth = booth.depth_m * z
    return [
        (np.array([-half, low, 0.0]), booth.width_m * x, depth, y),
        (np.array([-half, low, 0.0]), booth.height_m * y, depth, x),
        (np.array([half, low, 0.0]), booth.height_m * y, depth, -x),
    ]


def added_light(direct: RateImage, bounced: RateImage) -> list[tuple[str, float, float]]:
    """For each panel its name, what bounces add to direct light in green, relative, and the
    standard error of that.
    """
    rows = []
    for panel in direct.header.panels:
        before, after = (
            image.rate_e_per_s[panel.window][..., GREEN].mean(dtype=np.float64)
            for image in (direct, bounced)
        )
        variance = sum(
            image.variance[panel.window][..., GREEN].mean(dtype=np.float64)
            for image in (direct, bounced)
        )
        error = np.sqrt(variance / (panel.w * panel.h)) / before
        rows.append((panel.name, float(after / before - 1), float(error)))
    return rows
