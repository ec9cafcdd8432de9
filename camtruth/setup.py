"""What a simulation starts from, checked before anything is computed or written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from foundation.errors import InputError, unknown
from foundation.panel import Panel
from render.rate import RateImage, read_rate
from scenes import scene as scenes
from scenes.geometry import analysis_panels
from scenes.scene import Scene
from sensor import camera_file, protocol
from sensor.camera import Camera
from sensor.protocol import Protocol


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Everything that decides a simulated capture, except its seeds.

    Attributes:
        camera: the camera, its settings applied.
        protocol: the shots.
        scene: the scene, at the camera's number of pixels.
        images: rate images that are known already, by lamp.
    """

    camera: Camera
    protocol: Protocol
    scene: Scene
    images: dict[str, RateImage]

    @property
    def missing(self) -> tuple[str, ...]:
        """Lamps that must be rendered."""
        return tuple(lamp for lamp in self.protocol.lamps if lamp not in self.images)

    @property
    def scene_name(self) -> str:
        """The scene that the light came from."""
        if self.missing or not self.images:
            return self.scene.name
        return next(iter(self.images.values())).header.scene

    def panels_without_light(self) -> tuple[Panel, ...]:
        """Where the grey panels would be, for a capture of darks alone."""
        return analysis_panels(self.scene)


def prepare(
    *,
    camera: str,
    protocol_name: str,
    scene: str = "chart",
    rates: Sequence[str] = (),
    settings: Sequence[str] = (),
    body_seed: int = 0,
) -> Setup:
    """Load what the command line names.

    Args:
        camera, protocol_name, scene: names of presets, or TOML files.
        rates: ``LAMP=FILE`` each.
        settings: ``EFFECT.PARAMETER=VALUE`` each.
        body_seed: seed of the camera body.

    Raises:
        InputError: for the first thing that is unknown or does not fit.
    """
    body = camera_file.load(camera).with_body(body_seed)
    for setting in settings:
        body = camera_file.with_setting(body, setting)
    shots = protocol.load(protocol_name)
    where = scenes.load(scene).with_size(body.width, body.height)
    files = dict(_lamp_and_file(rate) for rate in rates)
    for lamp in shots.lamps:
        if lamp not in files and lamp not in where.lamp_names:
            raise unknown("lamp", lamp, {*where.lamp_names, *files}, InputError)
    for lamp in files:
        if lamp not in shots.lamps:
            raise unknown("lamp in --rate", lamp, shots.lamps, InputError)
    images = {lamp: _rate_that_fits(path, body) for lamp, path in files.items()}
    return Setup(camera=body, protocol=shots, scene=where, images=images)


def _lamp_and_file(option: str) -> tuple[str, Path]:
    lamp, equals, file = option.partition("=")
    if not (lamp and equals and file):
        raise InputError(
            f"--rate {option}", "expected LAMP=FILE", "as in --rate fluorescent=rate.exr"
        )
    return lamp, Path(file)


def _rate_that_fits(path: Path, camera: Camera) -> RateImage:
    image = read_rate(path)
    height, width, _ = image.rate_e_per_s.shape
    if (height, width) != (camera.height, camera.width):
        raise InputError(
            f"{path} has {width} x {height} pixels",
            f"expected {camera.width} x {camera.height} as camera '{camera.name}' has",
            "render it at that size",
        )
    return image
