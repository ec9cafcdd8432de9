"""PNG, 8 or 16 bit, one file a frame; written by Pillow."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from PIL import Image

from camtruth.exchange.format import EVERY_KIND, Format, one_file_a_frame
from camtruth.exchange.source import Source
from sensor.frames import Frames


def save(path: Path, _: Source, __: Frames, frame: NDArray[Any]) -> None:
    """Write a frame: grey, 16-bit grey or RGB; PNG loses nothing."""
    Image.fromarray(frame).save(path, format="PNG")


FORMAT = Format(
    name="png",
    says="PNG of 8 or 16 bits, one file a frame",
    media_type="image/png",
    reading="import cv2; frame = cv2.imread(FILE, cv2.IMREAD_UNCHANGED)  # colours as B, G, R",
    pixels=EVERY_KIND,
    write=one_file_a_frame("png", save, packed=True),
    stack="{label}/*.png",
    native=True,
)
