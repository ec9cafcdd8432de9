"""Defocus beyond the model."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class DefocusError(Effect):
    """The lens is focused elsewhere: every point becomes a disc, the picture of the lens opening.

    rate' = rate * k, k even over a disc of the given diameter D and nothing outside it. Variance of
    the spread along each axis D^2 / 16. A straight edge blurs over exactly D and is untouched
    beyond; a Gaussian of equal variance reaches further. Light is averaged before its shot noise is
    drawn, so noise stays independent from pixel to pixel, where a blur of the frames smooths it.
    Beyond the border the image goes on as at its edge.
    """

    name: ClassVar[str] = "defocus_error"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 40
    reference: ClassVar[str] = "geometrical optics: circle of confusion of a round aperture"

    diameter_px: float = parameter(
        3.0, unit="px", minimum=0.0, maximum=20.0, identity=0.0, doc="diameter of the extra disc"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        kernel = disc(self.diameter_px)
        rates = np.asarray(signal.value.numpy(), dtype=np.float32).reshape(signal.shape)
        # by Fourier transforms where a disc is large: light is never below nought
        soft = [np.maximum(_filtered(rate, kernel), 0.0) for rate in rates]
        return signal.from_numpy(np.stack(soft))


def _filtered(rate: NDArray[np.float32], kernel: NDArray[np.float64]) -> NDArray[np.float32]:
    import cv2

    return np.asarray(cv2.filter2D(rate, -1, kernel, borderType=cv2.BORDER_REPLICATE))


@functools.lru_cache(maxsize=64)
def disc(diameter_px: float) -> NDArray[np.float64]:
    """Weights of the pixels about one that a disc covers, (n, n) and n odd; they add to 1.

    Each weight is the area that a pixel shares with a disc. Sharing a square adds its own spread of
    1/12 px^2, so the disc is drawn a little smaller, to have a variance of D^2 / 16 all the same.
    """
    small, large = 0.0, diameter_px + 1.0
    for _ in range(40):
        middle = (small + large) / 2
        grid = _shared_area(middle)
        n = np.arange(len(grid)) - len(grid) // 2
        if (grid.sum(0) @ n**2) < diameter_px**2 / 16:
            small = middle
        else:
            large = middle
    return _shared_area(small)


def _shared_area(diameter_px: float) -> NDArray[np.float64]:
    """Part of a disc's area in each pixel about it; a disc within a pixel is all in that one."""
    radius = diameter_px / 2
    half = int(np.ceil(max(radius - 0.5, 0.0)))
    if half == 0:
        return np.ones((1, 1))
    strips = 64  # thin columns per pixel, each cut off by the circle exactly
    x = (np.arange((2 * half + 1) * strips) + 0.5) / strips - half - 0.5
    reach = np.sqrt(np.maximum(radius**2 - x**2, 0.0))
    n = np.arange(-half, half + 1)[:, None]
    cut = np.maximum(np.minimum(reach, n + 0.5) - np.maximum(-reach, n - 0.5), 0.0)
    area = cut.reshape(2 * half + 1, 2 * half + 1, strips).sum(-1)
    return np.asarray(area / area.sum())
