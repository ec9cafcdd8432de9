"""TIFF, 8 or 16 bit, one file a frame; written by tifffile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tifffile
from numpy.typing import NDArray

from camtruth.exchange.format import EVERY_KIND, Format, one_file_a_frame
from camtruth.exchange.source import Source
from sensor.frames import Frames


def photometric(frames: Frames) -> str:
    """What TIFF calls the meaning of the samples."""
    return "rgb" if frames.demosaiced else "minisblack"


def save(path: Path, _: Source, frames: Frames, frame: NDArray[Any]) -> None:
    """Write a frame, uncompressed."""
    tifffile.imwrite(path, frame, photometric=photometric(frames), metadata=None)


FORMAT = Format(
    name="tiff",
    says="TIFF of 8 or 16 bits, one file a frame",
    media_type="image/tiff",
    reading="import tifffile; frame = tifffile.imread(FILE)",
    pixels=EVERY_KIND,
    write=one_file_a_frame("tif", save, packed=False),
    stack="{label}/*.tif",
    native=True,
)
