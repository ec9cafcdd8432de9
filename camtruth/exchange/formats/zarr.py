"""Zarr version 3, one array a shot in one group; raw, so that it is as fast as the disk."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from camtruth.exchange.format import BATCH_BYTES, EVERY_KIND, Format, FrameFile, pieces
from camtruth.exchange.library import library
from camtruth.exchange.source import Source

GROUP = "frames.zarr"


def write(folder: Path, source: Source) -> Iterator[FrameFile]:
    """Write a capture as a group; each array's attributes say how its shot was taken."""
    zarr = library("zarr", "to write Zarr")
    root = zarr.open_group(str(folder / GROUP), mode="w-", zarr_format=3)
    root.attrs.update({"camera": source.document.camera, "bits": source.document.bits})
    for document, frames in source.shots:
        size = max(1, min(frames.count, BATCH_BYTES // max(1, frames.dn[0].nbytes)))
        array = root.create_array(
            name=frames.shot.label,
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
        name = f"{GROUP}/{frames.shot.label}"
        yield FrameFile(name=name, shot=frames.shot.label, first=0, count=frames.count)


FORMAT = Format(
    name="zarr",
    says="Zarr version 3, uncompressed, one array a shot",
    media_type="application/vnd+zarr",
    reading="import zarr; frames = zarr.open_array(FILE, mode='r')[:]",
    pixels=EVERY_KIND,
    write=write,
    stack=f"{GROUP}/{{label}}",
)
