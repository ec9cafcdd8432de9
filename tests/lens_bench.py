"""A lens in a scene, a batch of its rays, and an independent ray tracer."""

from __future__ import annotations

import dataclasses

import numpy as np

from scenes.lens import Lens
from scenes.prescription import mounted
from scenes.ray_trace import Rays, trace
from scenes.scene import Scene, load

SIZE = (160, 120)


def in_chart(lens: Lens, size: tuple[int, int] = SIZE) -> Scene:
    return dataclasses.replace(load("chart").with_size(*size), lens=lens)


def independent_ray(
    lens: Lens, place: np.ndarray, way: np.ndarray, nm: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """A ray from behind a spherical lens to before it, written down anew: spheres by geometry,
    refraction by Snell's angles in the plane of incidence. None where a rim stops it."""
    body = mounted(lens)
    index = [float(s.index_at(np.array(nm))) for s in body.surfaces]
    for n in reversed(range(len(index))):
        vertex = np.array([0.0, 0.0, body.vertex_m[n]])
        if body.curvature_per_m[n] == 0:
            place = place + way * (vertex[2] - place[2]) / way[2]
            normal = np.array([0.0, 0.0, -1.0])
        else:
            radius = 1 / body.curvature_per_m[n]
            centre = vertex + np.array([0.0, 0.0, radius])
            along = (centre - place) @ way
            off2 = ((centre - place) ** 2).sum() - along**2
            if off2 > radius**2:
                return None
            roots = along + np.array([-1, 1]) * np.sqrt(radius**2 - off2)
            points = place + roots[:, None] * way
            place = points[np.abs(points[:, 2] - vertex[2]).argmin()]
            normal = (place - centre) / radius
        if np.hypot(*place[:2]) > body.rim_m[n]:
            return None
        before = index[n - 1] if n else 1.0
        angle = np.arccos(np.clip(way @ normal, -1, 1))
        sine = np.sin(angle) * index[n] / before
        if sine > 1:
            return None
        if angle > 1e-12:
            across = (way - np.cos(angle) * normal) / np.sin(angle)
            way = np.sqrt(1 - sine**2) * normal + sine * across
    return place, way


def batch(lens: Lens, nm: float, count: int = 300) -> tuple[Rays, Rays]:
    body = mounted(lens)
    rng = np.random.default_rng(5)
    x, y = rng.uniform(-1.7e-3, 1.7e-3, (2, count))
    aim = 1.1 * body.exit_pupil_radius_m * rng.uniform(-1, 1, (2, count))
    way = np.stack([aim[0] - x, aim[1] - y, np.full(count, body.exit_pupil_m - body.detector_m)])
    way *= -np.sign(way[2]) / np.linalg.norm(way, axis=0)
    start = Rays(
        x=x,
        y=y,
        z=np.full(count, body.detector_m),
        dx=way[0],
        dy=way[1],
        dz=way[2],
        alive=np.ones(count, bool),
    )
    with np.errstate(all="ignore"):
        return start, trace(body, start, body.indices(np.array([nm])))


def chief_by_search(lens: Lens, radius: float) -> tuple[float, float]:
    """The pupil point whose ray passes the middle of the stop, by halving with open rims."""
    body = mounted(lens)
    behind = dataclasses.replace(
        body,
        vertex_m=body.vertex_m[body.stop :],
        rim_m=np.full(len(body.surfaces) - body.stop, 1.0),
        curvature_per_m=body.curvature_per_m[body.stop :],
        conic=body.conic[body.stop :],
        aspheric=body.aspheric[body.stop :],
        ideal_focal_m=body.ideal_focal_m[body.stop :],
        surfaces=body.surfaces[body.stop :],
    )

    def at_stop(px: float) -> float:
        way = np.array([px + radius, 0.0, body.exit_pupil_m - body.detector_m])
        way *= -np.sign(way[2]) / np.linalg.norm(way)
        one = np.ones(1)
        start = Rays(
            x=-radius * one,
            y=0 * one,
            z=body.detector_m * one,
            dx=way[0] * one,
            dy=way[1] * one,
            dz=way[2] * one,
            alive=one > 0,
        )
        return float(trace(behind, start, behind.indices(np.array([550.0]))).x[0])

    low, high = (side * body.exit_pupil_radius_m for side in (-0.6, 0.6))
    sign = np.sign(at_stop(high) - at_stop(low))
    assert at_stop(low) * at_stop(high) < 0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if at_stop(middle) * sign > 0 else (middle, high)
    return low, 0.0
