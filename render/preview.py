"""A picture to look at: the rate image balanced on its white panel, in sRGB.

For eyes alone: the camera's channels are taken as if they were those of sRGB, without a colour
matrix, so hues are those of the camera, not of the chart.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from render.rate import RateImage
from scenes.colour_science import colour

WHITE_PANEL = "19"
WHITE_LEVEL = 0.9
"""Linear level of the white panel, about its reflectance."""


def srgb(image: RateImage) -> NDArray[np.uint8]:
    """An sRGB picture of a rate image, (H, W, 3) uint8.

    Balanced on panel 19 where the image shows it, else on the brightest hundredth of each channel.
    """
    rate = image.rate_e_per_s.astype(np.float64)
    shown = {panel.name: panel for panel in image.header.panels}
    if WHITE_PANEL in shown:
        white = rate[shown[WHITE_PANEL].window].mean(axis=(0, 1))
    else:
        white = np.percentile(rate, 99, axis=(0, 1))
    balanced = WHITE_LEVEL * rate / np.where(white > 0, white, 1.0)
    encoded = colour.models.eotf_inverse_sRGB(np.clip(balanced, 0, 1))
    return np.asarray(np.round(255 * encoded), dtype=np.uint8)
