"""A scene as data: a chart, lamps, a lens and a detector, and where they stand.

Coordinates in metres, seen from the camera: the chart lies in the plane z = 0 with its centre at
the origin, x to the right, y up, z towards the camera, whose optical axis is the z axis.
A scene is written as TOML; copy a preset from scenes/presets/ and change it.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from foundation.documents import STRICT, read_toml
from foundation.errors import unknown
from scenes.chart import Booth, Chart
from scenes.check import refuse_impossible
from scenes.errors import SceneError
from scenes.lamp import Fraction, Lamp, Name, Positive
from scenes.lens import Lens


@dataclass(frozen=True, kw_only=True)
class Detector:
    """The light-sensitive surface: a grid of square pixels, centred on the optical axis.

    Attributes:
        width_px, height_px: size of the image.
        pitch_um: side of a pixel; all of it collects light (a microlens on every pixel).
        response: ``surrogate`` or the path of a CSV file ``nm,R,G,B``.
        infrared_cut: the path of a CSV file ``nm,value`` with the transmission of a filter before
            the sensor, where `response` is that of the bare sensor.
        peak_quantum_efficiency: electrons per photon at the tallest value of the response.
    """

    width_px: Annotated[int, Field(ge=8, le=8192)]
    height_px: Annotated[int, Field(ge=8, le=8192)]
    pitch_um: Positive
    response: str = "surrogate"
    infrared_cut: str | None = None
    peak_quantum_efficiency: Fraction

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """The absolute scale that is assumed: what one panel gives in one channel at lamp level 1."""

    panel: str
    channel: Literal["R", "G", "B"]
    rate_e_per_s: Positive

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything in front of the detector, and the detector.

    `lamp` keeps the spelling of the TOML file, where each lamp is a ``[[lamp]]``.

    Attributes:
        name: what to call it.
        chart: what is photographed.
        lamp: the lamps; each is rendered by itself.
        lens, detector: the camera's optics.
        camera_distance_m: from the chart to the lens.
        surround_reflectance: of the wall behind the chart, which fills the rest of the image.
        booth: what throws light back on the chart, when bounces are asked for.
        calibration: the absolute scale to which the lamps were adjusted.
    """

    name: Name
    chart: Chart
    lamp: Annotated[tuple[Lamp, ...], Field(min_length=1)]
    lens: Lens
    detector: Detector
    camera_distance_m: Positive
    surround_reflectance: Annotated[float, Field(ge=0, le=1)]
    booth: Booth | None = None
    calibration: Calibration

    __pydantic_config__ = STRICT

    @property
    def lamp_names(self) -> tuple[str, ...]:
        """The names of the lamps, in the order of the file."""
        return tuple(lamp.name for lamp in self.lamp)

    def named(self, lamp: str) -> Lamp:
        """The lamp of that name.

        Raises:
            SceneError: when the scene has none.
        """
        for known in self.lamp:
            if known.name == lamp:
                return known
        raise unknown("lamp", lamp, self.lamp_names, SceneError)

    def with_size(self, width_px: int, height_px: int) -> Scene:
        """The same picture on another number of pixels: the pitch follows the width."""
        pitch_um = self.detector.pitch_um * self.detector.width_px / width_px
        detector = dataclasses.replace(
            self.detector, width_px=width_px, height_px=height_px, pitch_um=pitch_um
        )
        return dataclasses.replace(self, detector=detector)


def preset_names() -> list[str]:
    """The scenes that come with the package."""
    folder = resources.files("scenes") / "presets"
    return sorted(
        p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml")
    )


FILES = (".csv", ".toml", ".ies")


def _beside(file: Path, word: str | None) -> str | None:
    """A file named in a scene lies beside the scene; other words are names."""
    return str(file.parent / word) if word is not None and word.lower().endswith(FILES) else word


def load(name: str) -> Scene:
    """A scene by preset name or by the path of a TOML file, proved to be possible.

    Raises:
        SceneError: for an unknown name, or a scene that cannot be photographed as it says.
        DocumentError: for a file that is not a scene.
    """
    if name in preset_names():
        path = Path(str(resources.files("scenes") / "presets" / f"{name}.toml"))
    elif Path(name).suffix == ".toml":
        path = Path(name)
    else:
        raise unknown("scene", name, preset_names(), SceneError)
    scene = _with_files(read_toml(path, Scene), path)
    refuse_impossible(scene)
    return scene


def _with_files(scene: Scene, path: Path) -> Scene:
    """The scene with the files that it names found beside it."""
    replace = dataclasses.replace
    chart, detector, lens = scene.chart, scene.detector, scene.lens
    if isinstance(chart.reflectances, str):
        chart = replace(chart, reflectances=_beside(path, chart.reflectances))
    return replace(
        scene,
        chart=chart,
        lens=replace(lens, prescription=_beside(path, lens.prescription)),
        lamp=tuple(
            replace(x, spd=_beside(path, x.spd), ies=_beside(path, x.ies)) for x in scene.lamp
        ),
        detector=replace(
            detector,
            response=_beside(path, detector.response),
            infrared_cut=_beside(path, detector.infrared_cut),
        ),
    )
