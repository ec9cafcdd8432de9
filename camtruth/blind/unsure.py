"""What nobody knows of a scene: the same light from one that is a little other than measured."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rates = Mapping[str, NDArray[np.float32]]

PANELS = (4, 6)
"""Of the chart, down and across: the reflectance of none is known well enough."""

SHIFT_PX = 0.3
BLUR_PX = 0.5


def unsure(rates: Rates, step: float) -> list[Rates]:
    """Light of scenes that are each a little other, in one thing, than the one that was measured.

    The shading of each lamp, the reflectance of each panel in each colour, the focus, and the
    place, scale and turn of the picture: who holds a real camera against a simulated one knows none
    of these better than calibration tells, and a severity that takes them for known is several
    times too high for everything that shows in the mean image.

    Args:
        rates: photo-electrons per second by lamp, (h, w, 3).
        step: relative change of shadings and reflectances.

    Returns:
        for each change photo-electrons per second by lamp, (h, w, 3).
    """
    h, w = next(iter(rates.values())).shape[:2]
    y, x = np.meshgrid(np.linspace(-1, 1, h), np.linspace(-1, 1, w), indexing="ij")
    out: list[Rates] = [
        {**rates, lamp: rates[lamp] * _as_gel(1 + step * shading)}
        for lamp in rates
        for shading in (x, y, x * x, x * y, y * y)
    ]
    down, across = PANELS
    cells = np.arange(h)[:, None] * down // h * across + np.arange(w) * across // w
    for cell in range(down * across):
        for c in range(3):
            gel = np.ones((h, w, 3), dtype=np.float32)
            gel[..., c] += step * (cells == cell)
            out.append({lamp: rate * gel for lamp, rate in rates.items()})
    out.append({lamp: cv2.GaussianBlur(rate, (0, 0), BLUR_PX) for lamp, rate in rates.items()})
    one, turn = 1 + SHIFT_PX / w, SHIFT_PX / w
    places = [
        ((1, 0, SHIFT_PX), (0, 1, 0)),
        ((1, 0, 0), (0, 1, SHIFT_PX)),
        ((one, 0, 0), (0, one, 0)),
        ((1, turn, 0), (-turn, 1, 0)),
    ]
    for place in places:
        matrix = np.array(place, dtype=np.float64)
        out.append({lamp: _placed(rate, matrix) for lamp, rate in rates.items()})
    return out


def _as_gel(image: Floats) -> NDArray[np.float32]:
    return image[..., None].astype(np.float32)


def _placed(rate: NDArray[np.float32], matrix: Floats) -> NDArray[np.float32]:
    h, w = rate.shape[:2]
    moved = cv2.warpAffine(
        rate, matrix, (w, h), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(moved, dtype=np.float32)
