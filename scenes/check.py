"""Whether a scene can be: what a file may say number by number and still not be possible."""

from __future__ import annotations

from typing import TYPE_CHECKING

from foundation.errors import unknown
from scenes.errors import SceneError
from scenes.geometry import COLUMNS, PANEL_NAMES, ROWS, mirror_point_m, panels
from scenes.lamps import emission
from scenes.spectra import reflectances, response

if TYPE_CHECKING:
    from scenes.scene import Scene


def refuse_impossible(scene: Scene) -> None:
    """Prove that a scene can be photographed as it says.

    Raises:
        SceneError: for the first thing that cannot be, with what to change.
    """
    _lens(scene)
    _chart(scene)
    _lamps(scene)
    refuse_specular(scene)
    reflectances(scene.chart.reflectances)
    response(scene.detector.response)
    for lamp in scene.lamp:
        emission(lamp)


def _lens(scene: Scene) -> None:
    lens = scene.lens
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
    if scene.calibration.panel not in PANEL_NAMES:
        raise unknown("calibration panel", scene.calibration.panel, PANEL_NAMES, SceneError)
    if not panels(scene):
        raise SceneError(
            f"no panel of scene '{scene.name}' is wholly in the image and clear of its blur",
            "expected at least one",
            "change camera_distance_m, focus_distance_m or the number of pixels",
        )


def _lamps(scene: Scene) -> None:
    for lamp in scene.lamp:
        if scene.lamp_names.count(lamp.name) > 1:
            raise SceneError(
                f"two lamps are called '{lamp.name}'", "expected every name once", "rename one"
            )
        if lamp.position_m[2] <= 0:
            raise SceneError(
                f"lamp '{lamp.name}' stands at z = {lamp.position_m[2]:g} m, not before the chart",
                "expected z above 0, the side of the camera",
                "correct position_m",
            )


def refuse_specular(scene: Scene) -> None:
    """Prove that no lamp is mirrored by the card into any point of the aperture.

    The image of the lamp in the plane of the chart, seen from anywhere on the aperture, has to
    lie outside the card.

    Raises:
        SceneError: naming the lamp and where its reflection falls.
    """
    margin_m = scene.lens.aperture_radius_m
    half_width_m, half_height_m = scene.chart.width_m / 2, scene.chart.height_m / 2
    for lamp in scene.lamp:
        x_m, y_m = mirror_point_m(scene, lamp)
        if abs(x_m) <= half_width_m + margin_m and abs(y_m) <= half_height_m + margin_m:
            raise SceneError(
                f"lamp '{lamp.name}' is mirrored into the lens at x = {x_m:.3g} m, y = {y_m:.3g} m"
                " of the chart",
                f"expected |x| above {half_width_m + margin_m:.3g} or |y| above"
                f" {half_height_m + margin_m:.3g}",
                "move the lamp away from the axis",
            )
