"""The camera, the witness and the lit chart, as plain data for Mitsuba; see `stage`."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from render import plugins, stage
from render.palette import Palette
from render.stage import MM_PER_M
from scenes.lamp import Lamp
from scenes.scene import Scene

Array = NDArray[np.float64]
Sampler = Literal["multijitter", "independent"]


def detector_factor(scene: Scene) -> Array:
    """From radiance to power on a pixel in m2 sr, (H, W): aperture / v^2, cos^4, pixel area."""
    lens = scene.lens
    image_m = lens.image_distance_m
    pitch_m = scene.detector.pitch_um * 1e-6
    right_m, up_m = places_m(scene)
    slant2 = 1 + (right_m**2 + up_m**2) / image_m**2
    on_axis = math.pi * (lens.aperture_radius_m / image_m) ** 2 * pitch_m**2 * lens.transmission
    return np.asarray(on_axis / slant2**2)


def places_m(scene: Scene) -> tuple[Array, Array]:
    """The middle of each pixel, to the right (1, W) and up (H, 1) from the centre, in m."""
    detector = scene.detector
    pitch_m = detector.pitch_um * 1e-6
    columns = (np.arange(detector.width_px) - (detector.width_px - 1) / 2) * pitch_m
    rows = (np.arange(detector.height_px) - (detector.height_px - 1) / 2) * pitch_m
    return np.asarray(columns)[None, :], -np.asarray(rows)[:, None]


def sensor(scene: Scene, palette: Palette, sampler: Sampler) -> dict[str, Any]:
    """The camera: looking down the z axis, image upright, its film the palette's channels."""
    lens, detector = scene.lens, scene.detector
    half_width_m = detector.width_px * detector.pitch_um * 1e-6 / 2
    nearest_mm = lens.barrel.distance_mm if lens.barrel else 1.0
    return {
        "type": "thinlens",
        "fov": 2 * math.degrees(math.atan(half_width_m / lens.image_distance_m)),
        "fov_axis": "x",
        "aperture_radius": lens.aperture_radius_m * MM_PER_M,
        "focus_distance": lens.focus_distance_m * MM_PER_M,
        "near_clip": nearest_mm / 10,
        "far_clip": 1e6,
        "to_world": stage.look_at(
            np.array([0.0, 0.0, scene.camera_distance_m * MM_PER_M]),
            np.zeros(3),
            np.array([0.0, 1.0, 0.0]),
        ),
        "film": film(scene, palette),
        "sampler": {"type": sampler},
    }


def film(scene: Scene, palette: Palette) -> dict[str, Any]:
    """A spectral film with the palette's channels, in single precision."""
    result: dict[str, Any] = {
        "type": "specfilm",
        "width": scene.detector.width_px,
        "height": scene.detector.height_px,
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    for channel, values in palette.film.items():
        result[f"srf_{channel}"] = even_curve(palette.film_nm, values)
    return result


def even_curve(nm: Array, value: Array) -> dict[str, Any]:
    """A spectrum of evenly spaced samples in Mitsuba's words, as a film response has to be.

    Args:
        nm, value: wavelengths in nm and values there, (n,) each.
    """
    return {
        "type": "regular",
        "wavelength_min": float(nm[0]),
        "wavelength_max": float(nm[-1]),
        "values": ", ".join(repr(float(x)) for x in value),
    }


def real_sensor(
    scene: Scene, palette: Palette, sampler: Sampler, true_nm: Array, one_wavelength: bool
) -> dict[str, Any]:
    """A camera whose rays go through the surfaces of a real lens.

    `true_nm` are the wavelengths that bend, evenly along the film; with `one_wavelength` the four
    of a path are made one, else they differ in name alone.
    """
    key = plugins.remember(scene, palette.film_nm[[0, -1]], true_nm, one_wavelength)
    return {
        "type": plugins.TRACED_LENS,
        "key": key,
        "film": film(scene, palette),
        "sampler": {"type": sampler},
    }


def witness(scene: Scene, sensor: dict[str, Any], integrator: dict[str, Any]) -> dict[str, Any]:
    """Nothing but the lens, its barrel and a black wall that glows with radiance 1 at all
    wavelengths.

    Each path meets barrel or wall and asks a lamp once, as in the chart's scene: the scalar
    backend draws one random number after the other, and the two have to draw equally many.
    """
    glow = {"type": "area", "radiance": {"type": "uniform", "value": 1.0}}
    return {
        "type": "scene",
        "integrator": integrator,
        "sensor": sensor,
        "wall": {**stage.wall(scene, stage.matt(stage.BLACK)), "emitter": glow},
        **stage.barrel(scene),
    }


def lit_chart(
    scene: Scene,
    lamp: Lamp,
    palette: Palette,
    sensor: dict[str, Any],
    integrator: dict[str, Any],
    bounces: int,
) -> dict[str, Any]:
    """The chart under its lamp, in its booth if light may bounce."""
    return {
        "type": "scene",
        "integrator": integrator,
        "sensor": sensor,
        **stage.lamps(scene, lamp),
        **stage.chart(scene, palette),
        **(stage.booth(scene) if bounces else {}),
    }
