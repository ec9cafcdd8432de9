"""A setting of the bias page: what camera, scene and protocol one cell of it simulates."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.closed_form import render
from scenes.scene import load as load_scene
from sensor.camera import Camera
from sensor.camera_file import load as load_camera
from sensor.camera_file import with_setting
from sensor.effects.demosaic import Demosaic
from sensor.effects.quantization import Quantization
from sensor.protocol import Protocol
from sensor.protocol import load as load_protocol
from sensor.truth import population

KEYS = ("read", "fpn", "shot_coefficient", "prnu_slope")
"""The parameters that equation (1) has; offsets have no truth but 0."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What varies between cells; the defaults are the paper's case.

    Attributes:
        camera: a preset.
        frames: frames per shot.
        size_px: side of a panel.
        black_dn, read_dn, fpn_dn: in place of the camera's, in all channels.
        step_dn: step of rounding; 2^-k for k more bits.
        demosaic: without it the native sites of each colour are measured.
        gradient: of the light within a panel, relative to the lamp's; 0 is even light.
        blur_px: further defocus.
        level: of the lamps, relative.
        exposure: of all shots, relative.
    """

    camera: str = "i400"
    frames: int = 100
    size_px: int = 50
    black_dn: float | None = None
    read_dn: float | None = None
    fpn_dn: float | None = None
    step_dn: float = 1.0
    demosaic: bool = True
    gradient: float = 1.0
    blur_px: float | None = None
    level: float = 1.0
    exposure: float = 1.0

    @property
    def slug(self) -> str:
        """A file name of what differs from the paper's case."""
        own = [
            f"{f.name}-{getattr(self, f.name)}"
            for f in dataclasses.fields(self)
            if getattr(self, f.name) != f.default
        ]
        return "_".join(own) or "paper"

    def made(self) -> Camera:
        """The camera of the setting, not rounding."""
        camera = load_camera(self.camera).without(Quantization)
        if self.black_dn is not None:
            camera = dataclasses.replace(camera, black_dn=self.black_dn)
        for effect, value in (
            ("read_noise.thermal_dn", self.read_dn),
            ("fpn.sigma_dn", self.fpn_dn),
            ("defocus_error.diameter_px", self.blur_px),
        ):
            camera = camera if value is None else with_setting(camera, f"{effect}={value}")
        return camera if self.demosaic else camera.without(Demosaic)

    def protocol(self) -> Protocol:
        """The paper's shots with the setting's frames and levels."""
        paper = load_protocol("paper")
        shots = [
            dataclasses.replace(
                shot,
                frames=self.frames,
                level=tuple(x * self.level for x in shot.level),
                exposure_s=shot.exposure_s * self.exposure,
            )
            for shot in paper.shot
        ]
        return dataclasses.replace(paper, shot=tuple(shots))


@functools.cache
def light() -> Mapping[str, NDArray[np.float32]]:
    """Rate images of the chart by lamp, in closed form."""
    scene = load_scene("chart")
    return {lamp: render(scene, lamp).rate_e_per_s for lamp in scene.lamp_names}


def truth(setting: Setting) -> dict[str, dict[str, float]]:
    """What went in, by channel and parameter, in DN."""
    camera = setting.made()
    longest = max(shot.exposure_s for shot in setting.protocol().shot)
    return {c: {k: of[k] for k in KEYS} for c, of in population(camera, longest).items()}
