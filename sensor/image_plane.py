"""Places in the image, and looking at light between its pixels."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import numpy as np

from sensor.colours import Colours
from sensor.signal import Format, Signal
from sensor.whole_numbers import whole_number


def from_centre_px(signal: Signal) -> tuple[Any, Any]:
    """How far below and to the right of the image's centre each pixel lies, in px.

    Tensors (1, H, 1, 1) and (1, 1, W, 1), which broadcast against a rate.
    """
    height, width = signal.shape[1:3]
    down = np.arange(height) - (height - 1) / 2
    right = np.arange(width) - (width - 1) / 2
    tensor = signal.backend.tensor
    return tensor(down[None, :, None, None]), tensor(right[None, None, :, None])


def half_diagonal_px(of: Format) -> float:
    """Distance in px from the centre of the image to its corner: r = 1 of radial models."""
    return math.hypot(of.height, of.width) / 2


def constant(signal: Signal, figure: float) -> Any:
    """One figure as a tensor (1, 1, 1, 1): data, so that a new value compiles nothing."""
    return signal.backend.tensor([[[[figure]]]])


def per_colour(signal: Signal, figure: float | Colours) -> Any:
    """A figure by colour as a tensor (1, 1, 1, 3): data, as in `constant`."""
    return signal.backend.tensor(np.reshape(list(Colours.of(figure)), (1, 1, 1, 3)))


def per_frame(signal: Signal, figures: Any) -> Any:
    """Figures by frame, F of them, as a tensor (F, 1, 1, 1)."""
    return signal.backend.tensor(np.reshape(figures, (-1, 1, 1, 1)))


def scene_mean(signal: Signal) -> Any:
    """The mean of a rate over the picture, by frame and colour: a tensor (f, 1, 1, 3)."""
    mean = dr.mean(dr.mean(signal.value, axis=2), axis=1)  # rows first: float32 sums stay short
    return type(mean)(mean.array, (signal.shape[0], 1, 1, 3))


def resampled(
    signal: Signal, down: Any, right: Any, straight: tuple[Any, Any] | None = None
) -> Any:
    """The rate at places between the pixels, by cubic convolution with a = -1/2.

    Exact for parabolas, and for the pixels themselves; places outside the image see its edge.
    The overshoot of a cubic beside a hard edge is cut off at no light.

    Args:
        signal: a rate (f, H, W, 3).
        down, right: where to look, in px from the centre: tensors that broadcast to (1, H, W, 3).
        straight: part of the way from the cubic to a straight line, down and to the right: tensors
            that broadcast likewise; 0 by default.

    Reference: Keys, IEEE Trans. Acoust. Speech Signal Process. 29, 1153 (1981).
    """
    f, height, width, depth = signal.shape
    flat = signal.value.array
    dr.eval(flat)
    index = dr.uint32_array_t(type(flat))
    nowhere = dr.zeros(type(signal.value), (1, height, width, depth))
    part_down, part_right = ((part + nowhere).array for part in straight or (nowhere, nowhere))
    rows, row_weights = _taps((down + (height - 1) / 2 + nowhere).array, height, part_down)
    columns, column_weights = _taps((right + (width - 1) / 2 + nowhere).array, width, part_right)

    lane = dr.arange(index, f * height * width * depth)
    frame = lane // (height * width * depth)
    place = lane - frame * (height * width * depth)
    colour = lane % depth
    if f > 1:
        pick = [*rows, *row_weights, *columns, *column_weights]
        dr.eval(*pick)
        pick = [dr.gather(type(array), array, place) for array in pick]
        rows, row_weights, columns, column_weights = (pick[k : k + 4] for k in (0, 4, 8, 12))
    total = dr.zeros(type(flat), dr.width(lane))
    for row, down_weight in zip(rows, row_weights, strict=True):
        start = (frame * height + row) * width
        along = sum(
            weight * dr.gather(type(flat), flat, (start + column) * depth + colour)
            for column, weight in zip(columns, column_weights, strict=True)
        )
        total = total + down_weight * along
    return type(signal.value)(dr.maximum(total, 0.0), signal.shape)


def _taps(position: Any, length: int, straight: Any) -> tuple[list[Any], list[Any]]:
    """The four samples about a position and their weights, a part of the way to those of a straight
    line; indices are held inside the image.
    """
    inside = dr.clip(position, 0.0, length - 1.0)
    first = dr.floor(inside)
    t = inside - first
    t2, t3 = t * t, t * t * t
    cubic = [
        -0.5 * t3 + t2 - 0.5 * t,
        1.5 * t3 - 2.5 * t2 + 1.0,
        -1.5 * t3 + 2.0 * t2 + 0.5 * t,
        0.5 * t3 - 0.5 * t2,
    ]
    line = (0.0, 1.0 - t, t, 0.0)
    weights = [c + straight * (s - c) for c, s in zip(cubic, line, strict=True)]
    places = [whole_number(dr.clip(first + k, 0.0, length - 1.0)) for k in (-1.0, 0.0, 1.0, 2.0)]
    return places, weights
