"""Capture folders: `capture.toml` and its frames, real or simulated alike.

Reading is strict and lazy: every statement of the manifest is checked against the files, and .npy
stacks stay on disk until somebody looks at them. Truth lies beside them and is never read here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tomli_w
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field

from foundation.backend import Backend
from foundation.documents import NAME, STRICT, read_toml, spelt
from foundation.panel import Panel
from sensor.camera import Camera
from sensor.errors import CaptureError
from sensor.frames import MOSAIC_WORDS, MOSAICS, PIXELS, Capture, Frames, Pixels
from sensor.protocol import DARK, Protocol, Shot, several
from sensor.record import Progress, stack_shape, take
from sensor.stack_files import read_stack

FORMAT = "camtruth-capture/1"
MANIFEST = "capture.toml"
TRUTH = "truth.json"


@dataclass(frozen=True, kw_only=True)
class ShotDocument:
    """A shot as the manifest spells it: `Shot`, but `frames` names the file or files."""

    label: Annotated[str, NAME]
    light: Annotated[tuple[str, ...], BeforeValidator(several), Field(min_length=1)] = (DARK,)
    level: Annotated[
        tuple[Annotated[float, Field(ge=0)], ...], BeforeValidator(several), Field(min_length=1)
    ] = (1.0,)
    exposure_s: Annotated[float, Field(ge=0, le=1e5)]
    frames: str
    rate: str | None = None
    interval_s: Annotated[float, Field(gt=0)] | None = None
    temperature_c: Annotated[float, Field(ge=-273.15, le=200)] | None = None

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class CaptureDocument:
    """The manifest; its keys are those of the capture format."""

    format: Annotated[str, Field(pattern=f"^{FORMAT}$")]
    camera: str
    pixels: Pixels
    bits: Annotated[int, Field(ge=1, le=16)]
    cfa: Annotated[str, spelt("|".join(MOSAICS), MOSAIC_WORDS)] | None = None
    scene: str | None = None
    shot: Annotated[tuple[ShotDocument, ...], Field(min_length=1)]
    panel: tuple[Panel, ...] = ()

    __pydantic_config__ = STRICT


def inside(folder: Path, name: str) -> Path:
    """The path of a file named in a manifest, which may not leave its folder.

    Raises:
        CaptureError: for an absolute path, or one that leads out, by `..` or by a link.
    """
    path = folder / name
    if "\0" in name or Path(name).is_absolute() or not _within(path, folder):
        raise CaptureError(
            f"the path '{name!s}' in {folder / MANIFEST} leaves the capture folder",
            "expected a path inside it",
            "move the file into the folder",
        )
    return path


def _within(path: Path, folder: Path) -> bool:
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):
        return False


def read_manifest(folder: Path) -> CaptureDocument:
    """The manifest of a capture folder, or a manifest itself.

    Raises:
        CaptureError: when there is no such folder.
        DocumentError: when the manifest is not one.
    """
    if not folder.is_dir():
        raise CaptureError(
            f"no folder {folder}", f"expected a capture folder with a {MANIFEST}", "check the path"
        )
    return read_toml(folder / MANIFEST, CaptureDocument)


def read_capture(folder: Path) -> Capture:
    """A capture from its folder; .npy stacks are memory-mapped.

    Raises:
        CaptureError: when files are missing, damaged, or not what the manifest says.
        DocumentError: when the manifest is not one.
    """
    document = read_manifest(folder)
    container_bits = 8 * np.dtype(PIXELS[document.pixels][1]).itemsize
    if document.bits > container_bits:
        raise CaptureError(
            f'bits = {document.bits} with pixels = "{document.pixels}" in {folder / MANIFEST}',
            f"expected at most {container_bits}",
            "correct one of them",
        )
    labels = [entry.label for entry in document.shot]
    stacks = []
    for entry in document.shot:
        if labels.count(entry.label) > 1:
            raise CaptureError(
                f"two shots are called '{entry.label}'", "expected every label once", "rename one"
            )
        if entry.rate is not None:
            inside(folder, entry.rate)
        dn = read_stack(folder, entry.frames, inside)
        shot = Shot(
            label=entry.label,
            light=entry.light,
            level=entry.level,
            exposure_s=entry.exposure_s,
            frames=max(len(dn), 1) if dn.ndim else 1,
            interval_s=entry.interval_s,
            temperature_c=entry.temperature_c,
        )
        frames = Frames(
            dn=dn, shot=shot, pixels=document.pixels, bits=document.bits, cfa=document.cfa
        )
        _check_samples(frames, container_bits)
        stacks.append(frames)
    return Capture(
        camera=document.camera,
        frames=tuple(stacks),
        panels=document.panel,
        scene=document.scene,
    )


def _check_samples(frames: Frames, container_bits: int) -> None:
    """Samples must fit the stated bits; only then is it worth reading them all."""
    if frames.count == 0 or frames.height < 2 or frames.width < 2:
        raise CaptureError(
            f"the frames of shot '{frames.shot.label}' have shape {frames.dn.shape}",
            "expected at least one frame of at least 2 x 2 pixels",
            "check the file",
        )
    if frames.bits == container_bits:
        return
    largest = max(int(frame.max()) for frame in frames.dn)
    if largest > frames.top_dn:
        raise CaptureError(
            f"shot '{frames.shot.label}' holds the value {largest}",
            f"expected at most {frames.top_dn} with bits = {frames.bits}",
            "correct 'bits', or shift the samples to the right",
        )


def write_capture(
    folder: Path,
    camera: Camera,
    protocol: Protocol,
    rates: Mapping[str, NDArray[np.float32]],
    *,
    seed: int,
    scene: str | None = None,
    panels: Sequence[Panel] = (),
    rate_files: Mapping[str, str] | None = None,
    where: Backend | None = None,
    progress: Progress = lambda frames: None,
) -> None:
    """Simulate a protocol into a folder, in chunks: memory does not grow with the frames.

    Args:
        folder: an existing folder to fill; see `foundation.output.new_folder`.
        camera: the camera.
        protocol: the shots.
        rates: photo-electrons per second by lamp, each (H, W, 3).
        seed: seed of what is not fixed in the camera body.
        scene: name of the scene, for the manifest.
        panels: areas to analyse, for the manifest.
        rate_files: names, inside the folder, of the rate images by lamp, where they are kept.
        where: the backend.
        progress: told the number of frames done.
    """
    kind = PIXELS[camera.pixels][1]
    for shot in protocol.shot:
        header = {
            "descr": np.lib.format.dtype_to_descr(np.dtype(kind)),
            "fortran_order": False,
            "shape": stack_shape(camera, shot),
        }
        # written, not mapped: a mapped file counts as memory of the process until it is closed
        with (folder / f"{shot.label}.npy").open("wb") as file:
            np.lib.format.write_array_header_1_0(file, header)
            for batch in take(camera, shot, rates, seed=seed, where=where):
                file.write(np.ascontiguousarray(batch, dtype=kind).data)
                progress(len(batch))
    write_manifest(folder, manifest_of(camera, protocol, scene, panels, rate_files or {}))


def manifest_of(
    camera: Camera,
    protocol: Protocol,
    scene: str | None,
    panels: Sequence[Panel],
    rate_files: Mapping[str, str],
) -> CaptureDocument:
    """The manifest of a simulated capture."""
    return CaptureDocument(
        format=FORMAT,
        camera=camera.name,
        pixels=camera.pixels,
        bits=camera.bits,
        cfa=camera.cfa_of_pixels,
        scene=scene,
        shot=tuple(
            ShotDocument(
                label=shot.label,
                light=shot.light,
                level=shot.level,
                exposure_s=shot.exposure_s,
                frames=f"{shot.label}.npy",
                rate=rate_files.get(shot.light[0]) if len(shot.light) == 1 else None,
                interval_s=shot.interval_s,
                temperature_c=shot.temperature_c,
            )
            for shot in protocol.shot
        ),
        panel=tuple(panels),
    )


def write_manifest(folder: Path, document: CaptureDocument) -> None:
    """Write `capture.toml`; lists of one are written as their single entry."""

    def plain(value: Any) -> Any:
        if isinstance(value, tuple) and len(value) == 1 and isinstance(value[0], (str, float)):
            return value[0]
        if isinstance(value, tuple):
            return [plain(item) for item in value]
        if hasattr(value, "__dataclass_fields__"):
            return {k: plain(v) for k, v in vars(value).items() if v is not None and v != ()}
        return value

    (folder / MANIFEST).write_text(tomli_w.dumps(plain(document)), encoding="utf-8")
