"""Pictures to look at: linear light as sRGB, nothing that a figure is measured from."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from foundation.output import new_file
from render import preview
from render.rate import RateImage


def srgb(linear: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Linear light from 0 to 1 as 8-bit sRGB (IEC 61966-2-1); the rest is clipped."""
    x = np.clip(linear, 0.0, 1.0)
    curve = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)
    return np.asarray(np.round(255 * curve), dtype=np.uint8)


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Pixels (H, W) or (H, W, 3) as the bytes of a PNG file."""
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(stream, format="png", optimize=True)
    return stream.getvalue()


def write_preview(path: Path, image: RateImage) -> None:
    """Write a rate image as a PNG to look at."""
    with new_file(path) as scratch:
        scratch.write_bytes(png(preview.srgb(image)))
