"""Multi-page TIFF, one file a shot; BigTIFF beyond 4 GB; written by tifffile."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import tifffile

from camtruth.exchange.format import (
    EVERY_KIND,
    Format,
    FrameFile,
    once,
    pieces,
    shot_by_shot,
)
from camtruth.exchange.formats.tiff import photometric
from camtruth.exchange.source import Source
from sensor.frames import Frames


def write(folder: Path, _: Source, frames: Frames) -> Iterator[FrameFile]:
    """Write a shot: first the tags of all pages, then the frames into the room left for them.

    Page by page takes twice as long, and all at once takes the memory of all frames.
    """
    name = f"{frames.shot.label}.tif"

    def make(path: Path) -> None:
        place = tifffile.imwrite(
            path,
            shape=frames.dn.shape,
            dtype=frames.dn.dtype,
            photometric=photometric(frames),
            returnoffset=True,
        )
        assert place is not None, "uncompressed frames of one series lie in one piece"
        with path.open("r+b") as stream:
            stream.seek(place[0])
            for _, piece in pieces(frames):
                stream.write(piece.data)

    kept = once(folder / name, make)
    yield FrameFile(name=name, shot=frames.shot.label, first=0, count=frames.count, kept=kept)


FORMAT = Format(
    name="tiff-pages",
    says="multi-page TIFF, one file a shot",
    media_type="image/tiff",
    reading="import tifffile; frames = tifffile.imread(FILE)",
    pixels=EVERY_KIND,
    write=shot_by_shot(write),
    stack="{label}.tif",
    native=True,
)
