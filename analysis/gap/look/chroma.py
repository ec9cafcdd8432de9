"""How many pixels of a row share a colour, told by what their colour differences may be.

R - G and B - G hold no luma: they are what the cable carried once for a group of pixels, and what
was drawn from it. With W a column for each group,

    differences of a row = W colours + rounding,      rounding of variance 2/12

so that all they have outside the columns of W is rounding. Noise that went through no such cable
has as much there as anywhere, and so has that of groups which begin one pixel later.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2

Floats = NDArray[np.float64]

WINDOW_PX = 32
"""Columns that are looked at together."""

FRAMES = 4
"""Of each shot."""

LARGEST = 2.0
"""What differences have outside W, in variances of rounding: clipped codes and codes of codes add
some to it."""

CLEAR = 2.0
"""By how much more groups that begin one pixel later leave."""

WAYS: tuple[Mapping[str, float], ...] = (
    {"mode": 2.0, "drawn": 0.0},
    {"mode": 2.0, "drawn": 1.0, "taken": 0.0},
    {"mode": 2.0, "drawn": 1.0, "taken": 1.0},
    {"mode": 1.0, "drawn": 0.0},
    {"mode": 1.0, "drawn": 1.0, "taken": 0.0},
    {"mode": 1.0, "drawn": 1.0, "taken": 1.0},
)
"""Those with the fewest colours first: what needs few can be made of more."""


def shared_colours(stacks: Sequence[NDArray[Any]]) -> Mapping[str, float] | None:
    """Which of `WAYS` these frames went; None where none.

    Where colours are drawn in lines, `taken` is 0 if they stand in the middle of a group.

    Args:
        stacks: frames of lit shots, (N, H, W, 3) codes.
    """
    rows = [_differences(stack[:FRAMES]) for stack in stacks if stack.ndim == 4]
    if not rows:
        return None
    for way in WAYS:
        outside = _outside(_lines(way))
        here, later = (_left(rows, outside, shift) for shift in (0, 1))
        if here < LARGEST * 2 * ROUNDING_DN2 and later > CLEAR * here:
            return way
    return None


def _differences(codes: NDArray[Any]) -> Floats:
    """R - G and B - G of every row: (rows, columns)."""
    green = codes[..., 1].astype(np.float64)
    both = [codes[..., c] - green for c in (0, 2)]
    return np.concatenate([one.reshape(-1, codes.shape[2]) for one in both])


def _lines(way: Mapping[str, float]) -> Floats:
    """W: what each colour gives to each column of a window, (columns, groups)."""
    group = 2 ** int(way["mode"])
    column = np.arange(WINDOW_PX)
    if not way["drawn"]:
        shares = np.equal.outer(column // group, np.arange(WINDOW_PX // group))
        return np.asarray(shares, dtype=np.float64)
    offset = 0.5 if way["taken"] == 0 else 0.0
    place = (column + offset) / group - offset
    distance = np.abs(np.subtract.outer(place, np.arange(-1, place[-1] + 2)))
    return np.asarray(np.maximum(1.0 - distance, 0.0))


def _outside(lines: Floats) -> Floats:
    """An orthonormal base of what no colours make: (columns, dimensions)."""
    left, size, _ = np.linalg.svd(lines)
    return np.asarray(left[:, int((size > 1e-9 * size[0]).sum()) :])


def _left(rows: Sequence[Floats], outside: Floats, shift: int) -> float:
    """Mean square of what rows have there, in windows that begin so many pixels later."""
    total, count = 0.0, 0
    for one in rows:
        # inside the picture, where no border has been mirrored
        begin = WINDOW_PX // 4 + shift
        windows = (one.shape[1] - begin - WINDOW_PX // 4) // WINDOW_PX
        cut = one[:, begin : begin + windows * WINDOW_PX].reshape(-1, WINDOW_PX)
        total += float(np.square(cut @ outside).sum())
        count += len(cut) * outside.shape[1]
    return total / count if count else float("inf")
