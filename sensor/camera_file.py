"""Cameras as TOML: presets, users' files, and what a diagnosis writes.

Each effect is a table ``[effects.NAME]``. A parameter whose name ends in ``_e`` may be written with
``_dn`` instead; it is divided by the camera's gain. Figures that differ by colour are tables,
``{R = 1.0, G = 2.0, B = 1.0}``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import tomli_w
from pydantic import Field

from foundation.documents import STRICT, read_toml
from foundation.errors import unknown
from foundation.output import new_file
from sensor.camera import Camera
from sensor.catalogue import catalogue, effect
from sensor.colours import Colours, PerColour
from sensor.effect import Effect
from sensor.errors import CameraError
from sensor.frames import MOSAIC_WORDS, MOSAICS, Pixels

FORMAT = "camtruth-camera/1"


@dataclass(frozen=True, kw_only=True)
class CameraDocument:
    """A camera as its TOML file spells it; see `Camera` for the meaning of the keys."""

    format: Annotated[str, Field(pattern=f"^{FORMAT}$")]
    name: str
    width: Annotated[int, Field(ge=4, le=16384)] = 640
    height: Annotated[int, Field(ge=4, le=16384)] = 480
    pixels: Pixels = "rgb8"
    bits: Annotated[int, Field(ge=1, le=16)] = 8
    cfa: str = "RGGB"
    gain_dn_per_e: PerColour
    black_dn: float = 0.0
    sensitivity: PerColour = field(default_factory=lambda: Colours.of(1.0))
    effects: dict[str, dict[str, float | Colours]] = field(default_factory=dict)

    __pydantic_config__ = STRICT


def preset_names() -> list[str]:
    """The cameras that come with the package."""
    folder = resources.files("sensor") / "cameras"
    return sorted(
        p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml")
    )


def load(name: str, kinds: Mapping[str, type[Effect]] | None = None) -> Camera:
    """A camera by preset name or by the path of a TOML file.

    Args:
        name: preset or path.
        kinds: further effects that the file may use, by name.

    Raises:
        CameraError: for a name that is neither, or a camera that cannot be.
        DocumentError: for a file that is not a camera.
    """
    if name in preset_names():
        path = Path(str(resources.files("sensor") / "cameras" / f"{name}.toml"))
    elif Path(name).suffix == ".toml":
        path = Path(name)
    else:
        raise unknown("camera", name, preset_names(), CameraError)
    return from_document(read_toml(path, CameraDocument), kinds)


def from_document(
    document: CameraDocument, kinds: Mapping[str, type[Effect]] | None = None
) -> Camera:
    """The camera that a document describes."""
    if document.pixels.startswith("bayer") and document.cfa not in MOSAICS:
        raise CameraError(
            f"{document.pixels} with cfa '{document.cfa}', which is no mosaic",
            f"expected {MOSAIC_WORDS}",
            "correct cfa or pixels",
        )
    bare = Camera(
        name=document.name,
        width=document.width,
        height=document.height,
        pixels=document.pixels,
        bits=document.bits,
        cfa=document.cfa,
        gain_dn_per_e=document.gain_dn_per_e,
        black_dn=document.black_dn,
        sensitivity=document.sensitivity,
    )
    known = {**catalogue(), **(kinds or {})}
    effects = []
    for name, values in document.effects.items():
        if name not in known:
            raise unknown("effect", name, known, CameraError)
        figures = dict(
            _in_electrons(known[name], written, figure, bare.gain_dn_per_e)
            for written, figure in values.items()
        )
        effects.append(known[name].with_parameters(figures))
    return dataclasses.replace(bare, effects=tuple(effects))


def _in_electrons(
    kind: type[Effect], written: str, figure: float | Colours, gain: Colours
) -> tuple[str, float | Colours]:
    name = f"{written.removesuffix('_dn')}_e"
    parameters = {p.name: p for p in kind.parameters()}
    if written in parameters or name not in parameters or not written.endswith("_dn"):
        return written, figure
    electrons = Colours.of(figure).map(lambda dn, g: dn / g, gain)
    return name, electrons if parameters[name].per_colour else electrons.G


def write(path: Path, camera: Camera) -> None:
    """Write a camera so that `load` gives it back."""
    document: dict[str, Any] = {
        "format": FORMAT,
        "name": camera.name,
        "width": camera.width,
        "height": camera.height,
        "pixels": camera.pixels,
        "bits": camera.bits,
        "cfa": camera.cfa,
        "gain_dn_per_e": camera.gain_dn_per_e.plain(),
        "black_dn": camera.black_dn,
        "sensitivity": camera.sensitivity.plain(),
        "effects": {e.name: e.values() for e in camera.effects},
    }
    with new_file(path) as scratch:
        scratch.write_text(tomli_w.dumps(document), encoding="utf-8")


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def with_setting(camera: Camera, setting: str) -> Camera:
    """The camera after one ``EFFECT.PARAMETER=VALUE`` of the command line.

    An effect it lacks is added with that figure; of one it has, that figure is changed. In DN where
    the parameter's ``_e`` is written ``_dn``.

    Raises:
        CameraError: for a setting of another form, an unknown effect or parameter, a bad value.
    """
    target, equals, text = setting.partition("=")
    name, dot, key = target.partition(".")
    value = _number(text)
    if not (equals and dot and name and key) or value is None:
        raise CameraError(
            f"setting '{setting}'",
            "expected EFFECT.PARAMETER=NUMBER, as in row_noise.sigma_e=12",
            f"see `camtruth effects {name}`" if name in catalogue() else "see `camtruth effects`",
        )
    kind = effect(name)
    parameter, figure = _in_electrons(kind, key, value, camera.gain_dn_per_e)
    present = camera.get(kind)
    values: dict[str, Any] = present.values() if present else {}
    return camera.plus(kind.with_parameters({**values, parameter: figure}))
