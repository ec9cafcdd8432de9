"""Zarr version 3, one array a shot in one group; raw, so that it is as fast as the disk."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from camtruth.exchange.format import BATCH_BYTES, EVERY_KIND, Format, FrameFile, once, pieces
from camtruth.exchange.library import library
from camtruth.exchange.source import Source
from sensor.capture_folder import ShotDocument
from sensor.frames import Frames

GROUP = "frames.zarr"
HEAD = "zarr.json"


def write(folder: Path, source: Source) -> Iterator[FrameFile]:
    """Write a capture as a group; each array's attributes say how its shot was taken."""
    zarr = library("zarr", "to write Zarr")
    (folder / GROUP).mkdir(exist_ok=True)
    once(folder / GROUP / HEAD, partial(_group, zarr, source))
    for document, frames in source.shots:
        kept = once(folder / GROUP / frames.shot.label, partial(_array, zarr, document, frames))
        name = f"{GROUP}/{frames.shot.label}"
        yield FrameFile(name=name, shot=frames.shot.label, first=0, count=frames.count, kept=kept)


def _group(zarr: Any, source: Source, path: Path) -> None:
    """Write the file that makes a folder a group."""
    scratch = path.with_name(".group")
    about = {"camera": source.document.camera, "bits": source.document.bits}
    zarr.open_group(str(scratch), mode="w", zarr_format=3, attributes=about)
    (scratch / HEAD).replace(path)
    scratch.rmdir()


def _array(zarr: Any, document: ShotDocument, frames: Frames, path: Path) -> None:
    size = max(1, min(frames.count, BATCH_BYTES // max(1, frames.dn[0].nbytes)))
    array = zarr.create_array(
        str(path),
        zarr_format=3,
        shape=frames.dn.shape,
        dtype=frames.dn.dtype,
        chunks=(size, *frames.dn.shape[1:]),
        compressors=None,
        dimension_names=("frame", "row", "column", "channel")[: frames.dn.ndim],
        attributes={
            "light": list(document.light),
            "level": list(document.level),
            "exposure_s": document.exposure_s,
        },
        config={"write_empty_chunks": True},  # or every chunk is searched for a value not 0
    )
    for first, piece in pieces(frames):
        array[first : first + len(piece)] = piece


FORMAT = Format(
    name="zarr",
    says="Zarr version 3, uncompressed, one array a shot",
    media_type="application/vnd+zarr",
    reading="import zarr; frames = zarr.open_array(FILE, mode='r')[:]",
    pixels=EVERY_KIND,
    write=write,
    stack=f"{GROUP}/{{label}}",
)
