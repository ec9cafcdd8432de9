"""What a rate image's header says of the optics and of the programs that made it."""

from __future__ import annotations

import dataclasses
import importlib.metadata

from scenes.geometry import blur_diameter_px
from scenes.scene import Scene

PROGRAMS = ("camtruth", "mitsuba", "drjit", "numpy", "colour-science")


def optics(scene: Scene, renderer: str) -> dict[str, float | str]:
    """The lens and the detector, flat, with the blur that follows from them."""
    result: dict[str, float | str] = {"renderer": renderer}
    for part in (scene.lens, scene.lens.barrel, scene.detector):
        if part is None:
            continue
        prefix = "barrel_" if part is scene.lens.barrel else ""
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            if isinstance(value, (int, float, str)):
                result[prefix + field.name] = value
    result["camera_distance_m"] = scene.camera_distance_m
    result["blur_diameter_px"] = blur_diameter_px(scene)
    return result


def versions() -> dict[str, str]:
    """The versions of the programs that decide the numbers; those not installed are left out."""
    result = {}
    for name in PROGRAMS:
        try:
            result[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return result
