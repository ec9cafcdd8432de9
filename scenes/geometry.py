"""Where things are: panels on the card in metres, and in the image in pixels.

A pixel position (column, row) counts from the top left corner of the image, so that the centre of
the first pixel is (0.5, 0.5).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from foundation.errors import unknown
from foundation.panel import Panel
from scenes.errors import SceneError
from scenes.imaging import blur_diameter_px, edge_margin_px, image_radius_m
from scenes.patches import GREY_ROW, PANEL_NAMES, Rectangle, patches

if TYPE_CHECKING:
    from scenes.lamp import Lamp
    from scenes.scene import Scene

__all__ = [
    "GREY_ROW",
    "PANEL_NAMES",
    "Rectangle",
    "analysis_panels",
    "blur_diameter_px",
    "mirror_point_m",
    "panel_rectangles",
    "panels",
    "place_m",
    "project",
    "turn",
]

Array = NDArray[np.float64]


def panel_rectangles(scene: Scene) -> dict[str, Rectangle]:
    """The upright part of each panel that nothing covers, on the card, by name."""
    return {patch.name: patch.clear for patch in patches(scene.chart)}


def turn(scene: Scene) -> Array:
    """The rotation matrix of the tilted card; its last column is the direction that it faces."""
    about_x, about_y = (math.radians(angle) for angle in scene.chart.tilt_deg)
    tip = [
        [1, 0, 0],
        [0, math.cos(about_x), -math.sin(about_x)],
        [0, math.sin(about_x), math.cos(about_x)],
    ]
    swing = [
        [math.cos(about_y), 0, math.sin(about_y)],
        [0, 1, 0],
        [-math.sin(about_y), 0, math.cos(about_y)],
    ]
    # The left side comes nearer: a turn of the right side away from the camera.
    return np.asarray(np.array(swing) @ np.array(tip))


def place_m(scene: Scene, x_m: float, y_m: float, lift_m: float = 0.0) -> tuple[float, ...]:
    """Where a point of the card is in space, x, y, z in m."""
    if scene.chart.tilt_deg == (0.0, 0.0):
        return x_m, y_m, lift_m
    return tuple(float(value) for value in turn(scene) @ [x_m, y_m, lift_m])


def project(scene: Scene, x_m: float, y_m: float) -> tuple[float, float]:
    """Where the chief ray from a point of the card meets the image, in px."""
    detector = scene.detector
    x_m, y_m, z_m = place_m(scene, x_m, y_m)
    scale = image_radius_m(scene, math.hypot(x_m, y_m), z_m) / (detector.pitch_um * 1e-6)
    return detector.width_px / 2 + x_m * scale, detector.height_px / 2 - y_m * scale


def panels(scene: Scene) -> tuple[Panel, ...]:
    """The part of each panel that is free of its edges: one blur diameter inside, whole pixels.

    Panels that the image cuts, or of which nothing is left, are left out; of a uniform card the
    image cuts off what it likes.
    """
    detector, result = scene.detector, []
    for name, where in panel_rectangles(scene).items():
        corners = [
            (x, y) for x in (where.left_m, where.right_m) for y in (where.bottom_m, where.top_m)
        ]
        lower_left, upper_left, lower_right, upper_right = (project(scene, *at) for at in corners)
        inset_px = max(edge_margin_px(scene, place_m(scene, *at)) for at in corners)
        left, right = max(lower_left[0], upper_left[0]), min(lower_right[0], upper_right[0])
        top, bottom = max(upper_left[1], upper_right[1]), min(lower_left[1], lower_right[1])
        x, y = math.ceil(left + inset_px), math.ceil(top + inset_px)
        w, h = math.floor(right - inset_px) - x, math.floor(bottom - inset_px) - y
        if scene.chart.pattern != "checker":
            (x, w), (y, h) = _cut(x, w, detector.width_px), _cut(y, h, detector.height_px)
        inside = x >= 0 and y >= 0 and x + w <= detector.width_px and y + h <= detector.height_px
        if inside and w >= 1 and h >= 1:
            result.append(Panel(name=name, x=x, y=y, w=w, h=h))
    return tuple(result)


def _cut(start: int, length: int, limit: int) -> tuple[int, int]:
    """The part of a span that lies inside the image."""
    end = min(start + length, limit)
    start = max(start, 0)
    return start, end - start


def analysis_panels(
    scene: Scene, names: Iterable[str] | None = None, size_px: int = 50
) -> tuple[Panel, ...]:
    """The square area at the centre of each named panel, as the paper analyses it.

    Without names: those of the grey row of a checker; all panels of other charts.

    Raises:
        SceneError: for a name that is not in the image, or an area larger than the panel.
    """
    known = {panel.name: panel for panel in panels(scene)}
    if names is None:
        names = GREY_ROW if scene.chart.pattern == "checker" else tuple(known)
    result = []
    for name in names:
        if name not in known:
            raise unknown("panel", name, known, SceneError)
        clear = known[name]
        column, row = _middle(scene, name, clear)
        x, y = round(column - size_px / 2), round(row - size_px / 2)
        fits = (
            size_px >= 1
            and clear.x <= x
            and clear.y <= y
            and x + size_px <= clear.x + clear.w
            and y + size_px <= clear.y + clear.h
        )
        if not fits:
            raise SceneError(
                f"an area of {size_px} x {size_px} px in panel '{name}'",
                f"expected 1 to {min(clear.w, clear.h) - 1} px, clear of the blurred edges",
                "choose a smaller area, or more pixels",
            )
        result.append(Panel(name=name, x=x, y=y, w=size_px, h=size_px))
    return tuple(result)


def _middle(scene: Scene, name: str, clear: Panel) -> tuple[float, float]:
    """The middle of a panel in the image; of one that the image may cut, that of what is left."""
    if scene.chart.pattern != "checker":
        return clear.x + clear.w / 2, clear.y + clear.h / 2
    where = panel_rectangles(scene)[name]
    return project(scene, (where.left_m + where.right_m) / 2, (where.bottom_m + where.top_m) / 2)


def mirror_point_m(
    scene: Scene, lamp: Lamp, part_m: tuple[float, float, float] | None = None
) -> tuple[float, float]:
    """Where a mirror in the plane of the chart would show the lamp to the lens centre, x, y in m.

    The straight line from the lamp (or another point of it, in m) to the lens centre reflected in
    the plane of the chart, in the coordinates of the card.
    """
    to_card = turn(scene).T
    x_m, y_m, z_m = to_card @ np.array(part_m or lamp.position_m)
    camera_m = to_card @ [0.0, 0.0, scene.camera_distance_m]
    part = camera_m[2] / (z_m + camera_m[2])
    return (
        float(camera_m[0] + (x_m - camera_m[0]) * part),
        float(camera_m[1] + (y_m - camera_m[1]) * part),
    )
