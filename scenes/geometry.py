"""Where things are: panels on the card in metres, and in the image in pixels.

A pixel position (column, row) counts from the top left corner of the image, so that the centre of
the first pixel is (0.5, 0.5).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from foundation.errors import unknown
from foundation.panel import Panel
from scenes.errors import SceneError

if TYPE_CHECKING:
    from scenes.scene import Lamp, Scene

ROWS, COLUMNS = 4, 6
"""A ColorChecker has 4 rows of 6 panels, named "1" to "24", row by row from the top left."""

PANEL_NAMES = tuple(str(number) for number in range(1, ROWS * COLUMNS + 1))
GREY_ROW = ("19", "20", "21", "22", "23", "24")


@dataclass(frozen=True, kw_only=True)
class Rectangle:
    """An upright rectangle in the plane of the chart, in m."""

    left_m: float
    bottom_m: float
    right_m: float
    top_m: float


def panel_rectangles(scene: Scene) -> dict[str, Rectangle]:
    """The 24 panels on the card, by name."""
    chart = scene.chart
    pitch_m, half_m = chart.panel_m + chart.gap_m, chart.panel_m / 2
    result = {}
    for index, name in enumerate(PANEL_NAMES):
        row, column = divmod(index, COLUMNS)
        x_m = (column - (COLUMNS - 1) / 2) * pitch_m
        y_m = ((ROWS - 1) / 2 - row) * pitch_m
        result[name] = Rectangle(
            left_m=x_m - half_m, bottom_m=y_m - half_m, right_m=x_m + half_m, top_m=y_m + half_m
        )
    return result


def project(scene: Scene, x_m: float, y_m: float) -> tuple[float, float]:
    """Where the ray from a point of the chart through the lens centre meets the image, in px."""
    detector = scene.detector
    scale = scene.lens.image_distance_m / (scene.camera_distance_m * detector.pitch_um * 1e-6)
    return detector.width_px / 2 + x_m * scale, detector.height_px / 2 - y_m * scale


def blur_diameter_px(scene: Scene) -> float:
    """Diameter of the disc into which defocus spreads a point of the chart, in px.

    Similar triangles behind a thin lens: 2 a v |1/u_focus - 1/u_chart|.
    """
    lens = scene.lens
    vergence = abs(1 / lens.focus_distance_m - 1 / scene.camera_distance_m)
    blur_m = 2 * lens.aperture_radius_m * lens.image_distance_m * vergence
    return blur_m / (scene.detector.pitch_um * 1e-6)


def panels(scene: Scene) -> tuple[Panel, ...]:
    """The part of each panel that is free of its edges: one blur diameter inside, whole pixels.

    Panels that the image cuts, or of which nothing is left, are left out.
    """
    inset_px = blur_diameter_px(scene)
    detector = scene.detector
    result = []
    for name, where in panel_rectangles(scene).items():
        left, top = project(scene, where.left_m, where.top_m)
        right, bottom = project(scene, where.right_m, where.bottom_m)
        x, y = math.ceil(left + inset_px), math.ceil(top + inset_px)
        w, h = math.floor(right - inset_px) - x, math.floor(bottom - inset_px) - y
        inside = x >= 0 and y >= 0 and x + w <= detector.width_px and y + h <= detector.height_px
        if inside and w >= 1 and h >= 1:
            result.append(Panel(name=name, x=x, y=y, w=w, h=h))
    return tuple(result)


def analysis_panels(
    scene: Scene, names: Iterable[str] = GREY_ROW, size_px: int = 50
) -> tuple[Panel, ...]:
    """The square area at the centre of each named panel, as the paper analyses it.

    Raises:
        SceneError: for a name that is not in the image, or an area larger than the panel.
    """
    known = {panel.name: panel for panel in panels(scene)}
    rectangles = panel_rectangles(scene)
    result = []
    for name in names:
        if name not in known:
            raise unknown("panel", name, known, SceneError)
        clear, where = known[name], rectangles[name]
        column, row = project(
            scene, (where.left_m + where.right_m) / 2, (where.bottom_m + where.top_m) / 2
        )
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


def mirror_point_m(scene: Scene, lamp: Lamp) -> tuple[float, float]:
    """Where a mirror in the plane of the chart would show the lamp to the lens centre, x, y in m.

    The straight line from the lamp to the lens centre reflected in z = 0.
    """
    x_m, y_m, z_m = lamp.position_m
    part = scene.camera_distance_m / (z_m + scene.camera_distance_m)
    return x_m * part, y_m * part
