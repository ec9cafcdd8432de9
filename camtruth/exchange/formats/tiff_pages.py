"""Multi-page TIFF, one file a shot; BigTIFF beyond 4 GB; written by tifffile."""

from __future__ import annotations

from pathlib import Path

import tifffile

from camtruth.exchange.format import EVERY_KIND, Format, one_file_a_shot, pieces
from camtruth.exchange.formats.tiff import photometric
from camtruth.exchange.source import Source
from sensor.frames import Frames


def save(path: Path, _: Source, frames: Frames) -> None:
    """Write a shot: first the tags of all pages, then the frames into the room left for them.

    Page by page takes twice as long, and all at once takes the memory of all frames.
    """
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
        for _first, piece in pieces(frames):
            stream.write(piece.data)


FORMAT = Format(
    name="tiff-pages",
    says="multi-page TIFF, one file a shot",
    media_type="image/tiff",
    reading="import tifffile; frames = tifffile.imread(FILE)",
    pixels=EVERY_KIND,
    write=one_file_a_shot("tif", save),
    stack="{label}.tif",
    native=True,
)
