"""Multi-page TIFF, one file a shot; BigTIFF beyond 4 GB; written by tifffile."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tifffile
from numpy.typing import NDArray

from camtruth.exchange.format import EVERY_KIND, Format, FrameFile, pieces, shot_by_shot
from camtruth.exchange.formats.tiff import photometric
from camtruth.exchange.source import Source
from sensor.frames import Frames


def write(folder: Path, _: Source, frames: Frames) -> Iterator[FrameFile]:
    """Write a shot, page by page."""
    name = f"{frames.shot.label}.tif"

    def pages() -> Iterator[NDArray[Any]]:
        for _, piece in pieces(frames):
            yield from piece

    tifffile.imwrite(
        folder / name,
        pages(),
        shape=frames.dn.shape,
        dtype=frames.dn.dtype,
        photometric=photometric(frames),
    )
    yield FrameFile(name=name, shot=frames.shot.label, first=0, count=frames.count)


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
