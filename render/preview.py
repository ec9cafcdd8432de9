"""Pictures to look at, in sRGB; nothing that a figure is measured from."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from foundation.output import new_file
from render.rate import RateImage

WHITE_PANELS = ("19", "bright", "1")
"""The panel to balance on: that of a ColorChecker, of an edge, of a wedge or an even card."""
WHITE_LEVEL = 0.9
"""Linear level of the white panel, about its reflectance."""


def srgb(linear: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Linear light from 0 to 1 as 8-bit sRGB (IEC 61966-2-1); the rest is clipped."""
    x = np.clip(linear, 0.0, 1.0)
    curve = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)
    return np.asarray(np.round(255 * curve), dtype=np.uint8)


def balanced(image: RateImage) -> NDArray[np.uint8]:
    """An sRGB picture of a rate image, (H, W, 3) uint8, whose white panel is neutral.

    The camera's channels are taken as if they were those of sRGB, without a colour matrix, so hues
    are those of the camera, not of the chart. Where the image shows no white panel it is balanced
    on the brightest hundredth of each channel.
    """
    rate = image.rate_e_per_s.astype(np.float64)
    shown = {panel.name: panel for panel in image.header.panels}
    known = next((shown[name] for name in WHITE_PANELS if name in shown), None)
    if known is not None:
        white = rate[known.window].mean(axis=(0, 1))
    else:
        white = np.percentile(rate, 99, axis=(0, 1))
    return srgb(WHITE_LEVEL * rate / np.where(white > 0, white, 1.0))


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Pixels (H, W) or (H, W, 3) as the bytes of a PNG file."""
    stream = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(stream, format="png")
    return stream.getvalue()


def write_preview(path: Path, image: RateImage) -> None:
    """Write a rate image as a PNG to look at."""
    with new_file(path) as scratch:
        scratch.write_bytes(png(balanced(image)))
