"""What Mitsuba is to build, as plain data: shapes, materials, lamps. No Mitsuba here.

Descriptions are Mitsuba's own dictionaries, except for three things that only `path_traced` can
make of it: a 4 x 4 array is a transformation, a `Picture` a texture, a `Mesh` a body of triangles.
Lengths are in millimetres: Mitsuba's ray offsets scale with the size of coordinates above 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from render import coat
from render.palette import CARD, WALL, Palette
from render.pupil import ring_mesh
from scenes.chart import Gloss
from scenes.geometry import blur_diameter_px, turn
from scenes.imaging import largest_slope
from scenes.lamp import Lamp
from scenes.lamps import axes, relative_intensity
from scenes.patches import Patch, flat, patches
from scenes.scene import Scene
from scenes.spectra import BAND_NM, Spectrum, spectrum

Array = NDArray[np.float64]

MM_PER_M = 1e3
CARD_BEHIND_M, WALL_BEHIND_M = 0.3e-3, 2e-3
"""The panels are glued on the card, and the card hangs on the wall."""
BLACK = spectrum(BAND_NM, (0.0, 0.0))

PICTURE_PX = 512
"""Sides of the picture of a lamp's directions: with linear interpolation good to 1e-5 where the
distribution is smooth."""
WIDEST_SLOPE = 8.0
"""A lamp lights what lies within 83 degrees of the direction from it to the chart's centre."""
SMALL_DISK = 0.25
"""A disk this small against its distance from the chart is 9 points of light, a larger one 36."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A grid of numbers that is interpolated linearly, row 0 at the top."""

    values: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Triangles of one material: vertices (N, 3) in mm."""

    name: str
    vertices: Array
    faces: NDArray[np.intp]
    bsdf: dict[str, Any]


def look_at(origin: Array, target: Array, up: Array) -> Array:
    """The 4 x 4 matrix of a camera or projector: left, up, forward, origin as columns."""
    forward = (target - origin) / np.linalg.norm(target - origin)
    left = np.cross(up, forward)
    left /= np.linalg.norm(left)
    result = np.eye(4)
    result[:3] = np.stack([left, np.cross(forward, left), forward, origin], axis=1)
    return result


def curve(values: Spectrum) -> dict[str, Any]:
    """A spectrum in Mitsuba's words: linear between samples."""
    if np.ptp(values.value) == 0:  # Mitsuba refuses a table of zeros
        return {"type": "uniform", "value": float(values.value[0])}
    return {
        "type": "irregular",
        "wavelengths": ", ".join(repr(float(x)) for x in values.nm),
        "values": ", ".join(repr(float(x)) for x in values.value),
    }


def matt(reflectance: Spectrum) -> dict[str, Any]:
    """A Lambertian surface."""
    return {"type": "diffuse", "reflectance": curve(reflectance)}


def coated(reflectance: Spectrum, gloss: Gloss | None) -> dict[str, Any]:
    """A Lambertian surface, under a rough dielectric coat if there is one."""
    if gloss is None:
        return matt(reflectance)
    return {
        "type": "roughplastic",
        "distribution": "beckmann",
        "alpha": gloss.roughness,
        "int_ior": gloss.index,
        "ext_ior": 1.0,
        "nonlinear": False,
        "diffuse_reflectance": curve(reflectance.times(coat.made_good(gloss))),
    }


def plate(middle_m: Array, across_m: Array, up_m: Array, bsdf: dict[str, Any]) -> dict[str, Any]:
    """A flat rectangle: its middle and its two half sides, in space."""
    normal = np.cross(across_m, up_m)
    place = np.eye(4)
    place[:3] = np.stack([across_m, up_m, normal / np.linalg.norm(normal), middle_m], axis=1)
    place[:3, [0, 1, 3]] *= MM_PER_M
    return {"type": "rectangle", "to_world": place, "bsdf": bsdf}


def chart(scene: Scene, palette: Palette) -> dict[str, Any]:
    """Panels on a card before a wall, and the barrel of the lens."""
    to_space = turn(scene)
    result = {
        f"panel_{patch.name}": _panel(patch, to_space, palette, scene.chart.gloss)
        for patch in patches(scene.chart)
    }
    half_m = scene.chart.width_m / 2, scene.chart.height_m / 2
    result["card"] = plate(
        to_space @ [0, 0, -CARD_BEHIND_M],
        to_space @ [half_m[0], 0, 0],
        to_space @ [0, half_m[1], 0],
        matt(palette.materials[CARD]),
    )
    result["wall"] = wall(scene, matt(palette.materials[WALL]))
    return result | barrel(scene)


def _panel(patch: Patch, to_space: Array, palette: Palette, gloss: Gloss | None) -> dict[str, Any]:
    angle = math.radians(patch.angle_deg)
    return plate(
        to_space @ [patch.x_m, patch.y_m, patch.lift_m],
        to_space @ [patch.half_width_m * math.cos(angle), -patch.half_width_m * math.sin(angle), 0],
        to_space
        @ [patch.half_height_m * math.sin(angle), patch.half_height_m * math.cos(angle), 0],
        coated(palette.materials[patch.name], gloss),
    )


def wall(scene: Scene, bsdf: dict[str, Any]) -> dict[str, Any]:
    """A wall behind the card that fills the image, its blur, and whatever the card leaves."""
    card_m = math.hypot(scene.chart.width_m, scene.chart.height_m) / 2
    behind_m = WALL_BEHIND_M if scene.chart.tilt_deg == (0.0, 0.0) else WALL_BEHIND_M + card_m
    pixels = math.hypot(scene.detector.width_px, scene.detector.height_px)
    room = 1.2 + 4 * blur_diameter_px(scene, (0.0, 0.0, -behind_m)) / pixels
    half_m = max(room * largest_slope(scene) * (scene.camera_distance_m + behind_m), card_m)
    return plate(
        np.array([0, 0, -behind_m]), np.array([half_m, 0, 0]), np.array([0, half_m, 0]), bsdf
    )


def barrel(scene: Scene) -> dict[str, Any]:
    """The black ring before a thin lens, if it has one."""
    if scene.lens.barrel is None:
        return {}
    vertices_m, faces = ring_mesh(scene)
    return {
        "barrel": Mesh(name="barrel", vertices=vertices_m * MM_PER_M, faces=faces, bsdf=matt(BLACK))
    }


def booth(scene: Scene) -> dict[str, Any]:
    """Table and side walls, which face the space before the chart."""
    size = scene.booth
    if size is None:
        return {}
    half_depth, half_height = size.depth_m / 2, size.height_m / 2
    grey = matt(flat(size.reflectance))
    x, y, z = np.eye(3)
    result = {
        "table": plate(
            np.array([0, -size.floor_m, half_depth]), z * half_depth, x * size.width_m / 2, grey
        )
    }
    for name, side in (("left", -1), ("right", 1)):
        middle = np.array([side * size.width_m / 2, half_height - size.floor_m, half_depth])
        across = -side * z * half_depth
        result[f"{name}_wall"] = plate(middle, y * half_height, across, grey)
    return result


def lamp_points(scene: Scene, lamp: Lamp) -> tuple[Array, Array]:
    """Points of a lamp (Q, 3) in m and their weights, which sum to 1: Q is 1, 9 or 36.

    Where every path asks all of them, a lamp of some size makes no noise; where each asks one, a
    stratified sampler asks all equally often if a batch has as many paths, or a multiple. A disk
    is a point in the middle and a ring of 8, exact for polynomials of degree 5, or 4 Gaussian
    rings of 9; a tube 9 Gaussian points.
    """
    middle = np.array(lamp.position_m)
    if lamp.kind == "tube":
        assert lamp.length_m is not None
        at, weight = np.polynomial.legendre.leggauss(9)
        along = np.array(lamp.axis) / np.linalg.norm(lamp.axis)
        return middle + np.outer(at * lamp.length_m / 2, along), weight / 2
    if lamp.kind != "disk":
        return middle[None, :], np.ones(1)
    assert lamp.diameter_m is not None
    if lamp.diameter_m < SMALL_DISK * np.linalg.norm(middle):
        radius = np.append(0.0, np.full(8, math.sqrt(2 / 3)))
        angle = np.append(0.0, np.arange(8) * math.pi / 4)
        weight = np.append(1 / 4, np.full(8, 3 / 32))
    else:
        at, ring = np.polynomial.legendre.leggauss(4)
        radius = np.repeat(np.sqrt((at + 1) / 2), 9)
        angle = np.tile(np.arange(9) * 2 * math.pi / 9, 4) + np.repeat(np.arange(4) / 4, 9)
        weight = np.repeat(ring / 2 / 9, 9)
    way = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return middle + lamp.diameter_m / 2 * way @ axes(lamp)[:2], weight


def lamps(scene: Scene, lamp: Lamp) -> dict[str, Any]:
    """Points of light of 1 W/sr in all per unit of film, each with its angular distribution."""
    points, weights = lamp_points(scene, lamp)
    if lamp.kind == "point" and lamp.ies is None:
        return {
            "lamp": {
                "type": "point",
                "position": [float(x) * MM_PER_M for x in points[0]],
                "intensity": {"type": "uniform", "value": MM_PER_M**2},
            }
        }
    return {
        f"lamp_{number}": _projector(scene, lamp, point, weight)
        for number, (point, weight) in enumerate(zip(points, weights, strict=True))
    }


def _projector(scene: Scene, lamp: Lamp, point: Array, weight: float) -> dict[str, Any]:
    """A point with an angular distribution: a slide projector aimed at the chart's centre.

    Mitsuba's projector gives, square to its axis at distance 1, pi times its picture; so a
    picture of I cos^3 / pi is the intensity I.
    """
    up = np.array([0.0, 1.0, 0.0]) if abs(point[1]) < 0.9 * np.linalg.norm(point) else np.eye(3)[0]
    frame = look_at(point * MM_PER_M, np.zeros(3), up)
    left, upward, forward = frame[:3, 0], frame[:3, 1], frame[:3, 2]
    slope = _slope_to_see(scene, point, frame)
    side = (np.arange(PICTURE_PX) + 0.5) / PICTURE_PX * 2 - 1
    right, down = np.meshgrid(side * slope, side * slope)
    directions = forward - right[..., None] * left - down[..., None] * upward
    length = np.linalg.norm(directions, axis=-1)
    intensity = relative_intensity(lamp, directions / length[..., None])
    return {
        "type": "projector",
        "to_world": frame,
        "fov": 2 * math.degrees(math.atan(slope)),
        "fov_axis": "x",
        "scale": weight * MM_PER_M**2 / math.pi,
        "irradiance": {
            "type": "bitmap",
            "bitmap": Picture(values=intensity / length**3),
            "raw": True,
            "filter_type": "bilinear",
            "wrap_mode": "clamp",
        },
    }


def _slope_to_see(scene: Scene, point: Array, frame: Array) -> float:
    """The slope off its axis that a projector needs to light the wall and the card."""
    placed = wall(scene, {})["to_world"][:3]
    card = turn(scene) @ np.diag([scene.chart.width_m / 2, scene.chart.height_m / 2, 0.0])
    corners = [
        corner
        for a in (-1, 1)
        for b in (-1, 1)
        for corner in (placed @ [a, b, 0, 1] / MM_PER_M, card @ [a, b, 0])
    ]
    seen = (np.array(corners) - point) @ frame[:3, :3]
    before = seen[:, 2] > 1e-3 * np.abs(seen[:, :2]).max(axis=1)
    slopes = np.abs(seen[before, :2]).max(axis=1) / seen[before, 2]
    return float(min(1.02 * slopes.max(), WIDEST_SLOPE)) if before.all() else WIDEST_SLOPE
