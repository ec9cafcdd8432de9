"""camtruth: camera frames with known noise, and what an estimator makes of them.

Everything that a script needs, under one name. Each name is read from its home when it is first
used, so that `import camtruth` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from analysis.gap.report import GapReport
    from analysis.parameters import CannotTell, Estimate, NoiseParameters
    from analysis.round_trip import Row
    from camtruth.diagnosing import diagnose
    from camtruth.measuring import measure, roundtrip
    from camtruth.rendering import render
    from camtruth.simulating import capture, capture_to
    from foundation.errors import InputError
    from foundation.panel import Panel
    from render.rate import RateImage, read_rate, write_rate
    from scenes.scene import Scene
    from scenes.scene import load as load_scene
    from sensor.camera import Camera
    from sensor.camera_file import load as load_camera
    from sensor.capture_folder import read_capture
    from sensor.effect import Effect
    from sensor.frames import Capture, Frames
    from sensor.protocol import Protocol, Shot
    from sensor.protocol import load as load_protocol
    from sensor.truth import population, truth

_HOMES = {
    "analysis.gap.report": ("GapReport",),
    "analysis.parameters": ("CannotTell", "Estimate", "NoiseParameters"),
    "analysis.round_trip": ("Row",),
    "camtruth.diagnosing": ("diagnose",),
    "camtruth.measuring": ("measure", "roundtrip"),
    "camtruth.rendering": ("render",),
    "camtruth.simulating": ("capture", "capture_to"),
    "foundation.errors": ("InputError",),
    "foundation.panel": ("Panel",),
    "render.rate": ("RateImage", "read_rate", "write_rate"),
    "scenes.scene": ("Scene",),
    "sensor.camera": ("Camera",),
    "sensor.capture_folder": ("read_capture",),
    "sensor.effect": ("Effect",),
    "sensor.frames": ("Capture", "Frames"),
    "sensor.protocol": ("Protocol", "Shot"),
    "sensor.truth": ("population", "truth"),
}
_LOADERS = {
    "load_camera": "sensor.camera_file",
    "load_protocol": "sensor.protocol",
    "load_scene": "scenes.scene",
}
_HOME_OF = {name: (home, name) for home, names in _HOMES.items() for name in names} | {
    name: (home, "load") for name, home in _LOADERS.items()
}

__all__ = [
    "Camera",
    "CannotTell",
    "Capture",
    "Effect",
    "Estimate",
    "Frames",
    "GapReport",
    "InputError",
    "NoiseParameters",
    "Panel",
    "Protocol",
    "RateImage",
    "Row",
    "Scene",
    "Shot",
    "capture",
    "capture_to",
    "diagnose",
    "load_camera",
    "load_protocol",
    "load_scene",
    "measure",
    "population",
    "read_capture",
    "read_rate",
    "render",
    "roundtrip",
    "truth",
    "write_rate",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'camtruth' has no attribute '{name}'")
    home, original = _HOME_OF[name]
    value = getattr(importlib.import_module(home), original)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
