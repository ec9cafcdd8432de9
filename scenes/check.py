"""Whether a scene can be: what a file may say number by number and still not be possible."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from foundation.errors import unknown
from scenes.errors import SceneError
from scenes.geometry import mirror_point_m, panels, place_m, turn
from scenes.imaging import largest_slope, real_field
from scenes.lamps import axes, emission
from scenes.patches import COLUMNS, ROWS, patches
from scenes.photometry import read_ies
from scenes.spectra import response

if TYPE_CHECKING:
    from scenes.lamp import Lamp
    from scenes.scene import Scene

PANELS_OF = {"uniform": (1, 1), "edge": (2, 2), "wedge": (2, 40)}
"""Least and most panels of the patterns whose reflectances are figures."""


def refuse_impossible(scene: Scene) -> None:
    """Prove that a scene can be photographed as it says.

    Raises:
        SceneError: for the first thing that cannot be, with what to change.
    """
    _lens(scene)
    _chart(scene)
    _lamps(scene)
    _booth(scene)
    refuse_specular(scene)
    response(scene.detector.response, scene.detector.infrared_cut)
    for lamp in scene.lamp:
        emission(lamp)


def _lens(scene: Scene) -> None:
    lens = scene.lens
    if (lens.kind == "real") != (lens.prescription is not None):
        raise SceneError(
            f"a lens of kind '{lens.kind}' with{'out' * (lens.prescription is None)} prescription",
            "expected a prescription of a real lens, and of no other",
            "change kind or prescription",
        )
    if lens.kind == "real" and lens.barrel is not None:
        raise SceneError(
            "a real lens with a barrel", "expected its own rims alone", "remove barrel"
        )
    focal_length_m = lens.focal_length_mm * 1e-3
    for what, distance_m in (
        ("focus_distance_m", lens.focus_distance_m),
        ("camera_distance_m", scene.camera_distance_m),
    ):
        if distance_m <= focal_length_m:
            raise SceneError(
                f"{what} = {distance_m:g} with a focal length of {lens.focal_length_mm:g} mm",
                "expected more than the focal length, or the lens forms no image",
                f"increase {what}",
            )
    real_field(scene)
    if lens.barrel is None:
        return
    aperture_mm = lens.aperture_radius_m * 1e3
    if lens.barrel.radius_mm < aperture_mm:
        raise SceneError(
            f"a barrel of radius {lens.barrel.radius_mm:g} mm before an aperture of"
            f" {aperture_mm:.3g} mm",
            "expected the barrel to be the wider one",
            "increase radius_mm or f_number",
        )
    nearest_m = min(lens.focus_distance_m, scene.camera_distance_m)
    if lens.barrel.distance_mm * 1e-3 >= nearest_m / 2:
        raise SceneError(
            f"a barrel {lens.barrel.distance_mm:g} mm before the aperture",
            f"expected less than {nearest_m * 500:g} mm, half way to what is photographed",
            "decrease distance_mm",
        )


def _chart(scene: Scene) -> None:
    chart = scene.chart
    if chart.pattern == "checker":
        _checker(scene)
    else:
        least, most = PANELS_OF[chart.pattern]
        given = chart.reflectances
        if isinstance(given, str) or not least <= len(given) <= most:
            count = f"{least}" if least == most else f"{least} to {most}"
            raise SceneError(
                f"reflectances = {given!r} of a chart of pattern '{chart.pattern}'",
                f"expected {count} figures between 0 and 1",
                "correct reflectances",
            )
        strips_m = chart.width_m - (len(given) + 1) * chart.gap_m
        if strips_m <= 0 or 2 * chart.gap_m >= chart.height_m:
            raise SceneError(
                f"gap_m = {chart.gap_m:g} on a card of {chart.width_m:g} x {chart.height_m:g} m",
                "expected room for panels between the gaps",
                "decrease gap_m",
            )
    names = [patch.name for patch in patches(chart)]
    if scene.calibration.panel not in names:
        raise unknown("calibration panel", scene.calibration.panel, names, SceneError)
    corners = [(x * chart.width_m / 2, y * chart.height_m / 2) for x in (-1, 1) for y in (-1, 1)]
    nearest_m = max(place_m(scene, *corner)[2] for corner in corners)
    if nearest_m >= scene.camera_distance_m / 2:
        raise SceneError(
            f"the tilted card comes within {scene.camera_distance_m - nearest_m:.3g} m of the lens",
            "expected it to stay beyond half of camera_distance_m",
            "decrease tilt_deg",
        )
    if not panels(scene):
        raise SceneError(
            f"no panel of scene '{scene.name}' is wholly in the image and clear of its blur",
            "expected at least one",
            "change camera_distance_m, focus_distance_m or the number of pixels",
        )


def _checker(scene: Scene) -> None:
    chart = scene.chart
    if not isinstance(chart.reflectances, str) or chart.panel_m is None:
        raise SceneError(
            "a checker whose reflectances are figures, or without panel_m",
            "expected the name of a table of reflectances, and panel_m",
            "name a chart of colour-science or a CSV file",
        )
    for what, count, size_m in (
        ("width_m", COLUMNS, chart.width_m),
        ("height_m", ROWS, chart.height_m),
    ):
        needed_m = count * chart.panel_m + (count - 1) * chart.gap_m
        if needed_m > size_m:
            raise SceneError(
                f"chart {what} = {size_m:g}",
                f"expected at least {needed_m:g} for {count} panels and the gaps between them",
                f"increase {what}, or decrease panel_m or gap_m",
            )


def _lamps(scene: Scene) -> None:
    facing = turn(scene)[:, 2]
    for lamp in scene.lamp:
        if scene.lamp_names.count(lamp.name) > 1:
            raise SceneError(
                f"two lamps are called '{lamp.name}'", "expected every name once", "rename one"
            )
        _lamp(lamp)
        for part_m in outermost_m(lamp):
            before_m = min(part_m[2], sum(a * b for a, b in zip(part_m, facing, strict=True)))
            if before_m <= 0:
                raise SceneError(
                    f"lamp '{lamp.name}' stands at z = {part_m[2]:g} m, not before the chart",
                    "expected z above 0, the side of the camera that the chart faces",
                    "correct position_m",
                )


def _lamp(lamp: Lamp) -> None:
    """What the words of one lamp have to be among themselves."""
    if (lamp.spd is None) == (lamp.temperature_k is None):
        raise SceneError(
            f"lamp '{lamp.name}' with {'neither' if lamp.spd is None else 'both'} spd and"
            " temperature_k",
            "expected one of the two",
            "give the lamp one colour",
        )
    needed = {"point": (), "disk": ("diameter_m",), "tube": ("length_m",)}[lamp.kind]
    for word in ("diameter_m", "length_m", "ies"):
        given = getattr(lamp, word) is not None
        if word in needed and not given:
            raise SceneError(
                f"lamp '{lamp.name}' of kind '{lamp.kind}' without {word}",
                "it is required",
                f"add {word} = ...",
            )
        if given and word not in needed and (word, lamp.kind) != ("ies", "point"):
            raise SceneError(
                f"lamp '{lamp.name}' of kind '{lamp.kind}' with {word}",
                "expected none",
                f"remove {word}, or change kind",
            )
    if lamp.aim_m == lamp.position_m or not any(lamp.axis):
        raise SceneError(
            f"lamp '{lamp.name}' points nowhere",
            "expected aim_m away from position_m, and an axis that is not 0, 0, 0",
            "correct aim_m or axis",
        )
    if lamp.ies is not None:
        read_ies(lamp.ies)


def outermost_m(lamp: Lamp) -> list[tuple[float, float, float]]:
    """The middle of a lamp and its outermost parts, x, y, z in m."""
    middle = np.array(lamp.position_m)
    ways = [np.zeros(3)]
    if lamp.kind == "disk" and lamp.diameter_m is not None:
        ways += [side * lamp.diameter_m / 2 * way for way in axes(lamp)[:2] for side in (-1, 1)]
    if lamp.kind == "tube" and lamp.length_m is not None:
        along = np.array(lamp.axis) / np.linalg.norm(lamp.axis)
        ways += [side * lamp.length_m / 2 * along for side in (-1, 1)]
    return [tuple(float(x) for x in middle + way) for way in ways]  # type: ignore[misc]


def _booth(scene: Scene) -> None:
    booth = scene.booth
    if booth is None:
        return
    if scene.chart.width_m >= booth.width_m or scene.chart.height_m / 2 >= booth.floor_m:
        raise SceneError(
            f"a chart of {scene.chart.width_m:g} x {scene.chart.height_m:g} m in a booth"
            f" {booth.width_m:g} m wide with the table {booth.floor_m:g} m below its centre",
            "expected the chart inside",
            "increase width_m or floor_m of the booth",
        )
    seen_m = 1.1 * largest_slope(scene) * scene.camera_distance_m
    if min(booth.width_m / 2, booth.floor_m) <= seen_m:
        raise SceneError(
            f"a booth {booth.width_m:g} m wide with its table {booth.floor_m:g} m below",
            f"expected both farther than {seen_m:.3g} m from the axis, out of the picture",
            "increase width_m or floor_m of the booth",
        )
    for lamp in scene.lamp:
        for x_m, y_m, _ in outermost_m(lamp):
            if abs(x_m) >= booth.width_m / 2 or y_m <= -booth.floor_m:
                raise SceneError(
                    f"lamp '{lamp.name}' stands at x = {x_m:g} m, y = {y_m:g} m, outside the booth",
                    f"expected |x| below {booth.width_m / 2:g} and y above {-booth.floor_m:g}",
                    "widen the booth or move the lamp",
                )


def refuse_specular(scene: Scene) -> None:
    """Prove that no part of a lamp is mirrored by the card into any point of the aperture.

    The image of the lamp in the plane of the chart, seen from anywhere on the aperture, has to
    lie outside the card. A chart with a glossy coat may be photographed as badly as one likes.

    Raises:
        SceneError: naming the lamp and where its reflection falls.
    """
    if scene.chart.gloss is not None:
        return
    margin_m = scene.lens.aperture_radius_m
    half_width_m, half_height_m = scene.chart.width_m / 2, scene.chart.height_m / 2
    for lamp in scene.lamp:
        for part_m in outermost_m(lamp):
            x_m, y_m = mirror_point_m(scene, lamp, part_m)
            if abs(x_m) <= half_width_m + margin_m and abs(y_m) <= half_height_m + margin_m:
                raise SceneError(
                    f"lamp '{lamp.name}' is mirrored into the lens at x = {x_m:.3g} m,"
                    f" y = {y_m:.3g} m of the chart",
                    f"expected |x| above {half_width_m + margin_m:.3g} or |y| above"
                    f" {half_height_m + margin_m:.3g}",
                    "move the lamp away from the axis, or give the chart a gloss to see it",
                )
