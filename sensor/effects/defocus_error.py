"""Defocus beyond the model."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr
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
        flat = signal.value.array
        dr.eval(flat)
        kind, index = type(flat), dr.uint32_array_t(type(flat))
        whole = dr.int32_array_t(index)
        weights, rows, columns = disc(self.diameter_px)
        table = signal.backend.tensor(weights).array
        downs, rights = (whole(np.ascontiguousarray(n, dtype=np.int32)) for n in (rows, columns))
        taps = dr.opaque(signal.backend.arrays.UInt32, len(weights))

        f, height, width, depth = signal.shape
        lane = dr.arange(index, f * height * width * depth)
        pixel = lane // depth
        line = pixel // width
        column, colour = pixel - line * width, lane - pixel * depth
        frame = line // height
        row = line - frame * height

        def step(tap: Any, total: Any) -> tuple[Any, Any]:
            at = index(tap)
            y = index(dr.clip(whole(row) + dr.gather(whole, downs, at), 0, height - 1))
            x = index(dr.clip(whole(column) + dr.gather(whole, rights, at), 0, width - 1))
            light = dr.gather(kind, flat, ((frame * height + y) * width + x) * depth + colour)
            return tap + 1, total + dr.gather(kind, table, at) * light

        start = (signal.backend.arrays.UInt32(0), dr.zeros(kind, dr.width(lane)))
        _, total = dr.while_loop(
            start, lambda tap, total: tap < taps, step, labels=("tap", "total")
        )
        return signal.replace(type(signal.value)(total, signal.shape))


@functools.lru_cache(maxsize=64)
def disc(diameter_px: float) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """Weights, rows and columns of the pixels that a disc covers; the weights add to 1.

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
    grid = _shared_area(small)
    rows, columns = np.nonzero(grid > 1e-6)
    weights = grid[rows, columns]
    half = len(grid) // 2
    return (
        weights / weights.sum(),
        (rows - half).astype(np.int32),
        (columns - half).astype(np.int32),
    )


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
