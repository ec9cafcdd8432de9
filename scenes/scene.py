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
from scenes.check import refuse_impossible
from scenes.errors import SceneError

Positive = Annotated[float, Field(gt=0)]
Fraction = Annotated[float, Field(gt=0, le=1)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$")]
Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A matt ColorChecker: 24 square panels on a dark card.

    Attributes:
        reflectances: name of a chart of colour-science, for the 24 panels.
        width_m, height_m: size of the card in m.
        panel_m: side of a panel in m.
        gap_m: card between two panels in m.
        frame_reflectance: reflectance of the card, equal at all wavelengths.
    """

    reflectances: str
    width_m: Positive
    height_m: Positive
    panel_m: Positive
    gap_m: Positive
    frame_reflectance: Annotated[float, Field(ge=0, le=1)]

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Filter:
    """A gel in front of a lamp that brings its colour nearer to the camera's liking.

    The transmission is that of two ideal gels on top of each other, scaled so that its highest
    value from 400 to 700 nm is `peak_transmission`: a colour conversion gel, which multiplies by
    exp(-c2 M / wavelength) and so moves a black body by M = `mired_shift` (negative: bluer;
    Wien's law), and a magenta gel with the optical density `green_density` at 540 nm and a
    Gaussian band of 40 nm standard deviation (negative: a green gel).
    """

    mired_shift: Annotated[float, Field(ge=-500, le=500)]
    green_density: Annotated[float, Field(ge=-2, le=2)]
    peak_transmission: Fraction = 0.9

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Lamp:
    """A point source that shines equally in all directions.

    Attributes:
        name: what a protocol calls it.
        kind: ``point``.
        spd: name of a spectrum of colour-science, or the path of a CSV file ``nm,value``.
        position_m: x, y, z in m.
        intensity_w_per_sr: radiant intensity from 400 to 700 nm in W/sr at level 1, before the gel.
        filter: the gel, if there is one.
        note: what is assumed about it.
    """

    name: Name
    kind: Literal["point"] = "point"
    spd: str
    position_m: Point
    intensity_w_per_sr: Positive
    filter: Filter | None = None
    note: str = ""

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Barrel:
    """The round front opening of the lens mount, which cuts oblique light (vignetting).

    Attributes:
        radius_mm: radius of the opening.
        distance_mm: from the aperture towards the scene.
    """

    radius_mm: Positive
    distance_mm: Positive

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Lens:
    """A thin lens with a round aperture.

    Attributes:
        kind: ``thin``.
        focal_length_mm: focal length.
        f_number: focal length over aperture diameter.
        focus_distance_m: from the lens to what is sharp; the chart is meant not to be.
        transmission: part of the light that passes the glass.
        barrel: the front opening, if it is to cut light.
    """

    kind: Literal["thin"] = "thin"
    focal_length_mm: Positive
    f_number: Positive
    focus_distance_m: Positive
    transmission: Fraction = 1.0
    barrel: Barrel | None = None

    __pydantic_config__ = STRICT

    @property
    def aperture_radius_m(self) -> float:
        """Radius of the aperture in m."""
        return self.focal_length_mm * 1e-3 / (2 * self.f_number)

    @property
    def image_distance_m(self) -> float:
        """From the lens to the detector in m, by the thin lens equation at the focus distance."""
        focal_length_m = self.focal_length_mm * 1e-3
        return 1 / (1 / focal_length_m - 1 / self.focus_distance_m)


@dataclass(frozen=True, kw_only=True)
class Detector:
    """The light-sensitive surface: a grid of square pixels, centred on the optical axis.

    Attributes:
        width_px, height_px: size of the image.
        pitch_um: side of a pixel; all of it collects light (a microlens on every pixel).
        response: ``surrogate`` or the path of a CSV file ``nm,R,G,B``.
        peak_quantum_efficiency: electrons per photon at the tallest value of the response.
    """

    width_px: Annotated[int, Field(ge=8, le=8192)]
    height_px: Annotated[int, Field(ge=8, le=8192)]
    pitch_um: Positive
    response: str = "surrogate"
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
        calibration: the absolute scale to which the lamps were adjusted.
    """

    name: Name
    chart: Chart
    lamp: Annotated[tuple[Lamp, ...], Field(min_length=1)]
    lens: Lens
    detector: Detector
    camera_distance_m: Positive
    surround_reflectance: Annotated[float, Field(ge=0, le=1)]
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


def _beside(file: Path, word: str) -> str:
    """A CSV file named in a scene lies beside the scene; other words are names."""
    return str(file.parent / word) if word.endswith(".csv") else word


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
    scene = read_toml(path, Scene)
    scene = dataclasses.replace(
        scene,
        lamp=tuple(dataclasses.replace(x, spd=_beside(path, x.spd)) for x in scene.lamp),
        detector=dataclasses.replace(
            scene.detector, response=_beside(path, scene.detector.response)
        ),
    )
    refuse_impossible(scene)
    return scene
