"""A small scene and a camera for it, of which sets are made."""

from __future__ import annotations

from render.closed_form import render
from render.rate import RateImage
from scenes.scene import load as load_scene
from sensor import camera_file
from sensor.camera import Camera

WIDTH, HEIGHT = 64, 48


def light() -> dict[str, RateImage]:
    scene = load_scene("chart").with_size(WIDTH, HEIGHT)
    return {"incandescent": render(scene, "incandescent")}


def bases() -> dict[str, Camera]:
    return {"icx098": camera_file.load("icx098").resized(HEIGHT, WIDTH)}
