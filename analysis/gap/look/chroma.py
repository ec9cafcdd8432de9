"""How many pixels share a colour, told by what the colour differences of a row may be.

R - G and B - G hold no luma: they are what the cable carried once for a group of pixels, and what
was drawn from it. With W a column for each group,

    differences of a row = W colours + rounding,      rounding of variance 2/12

so that all they have outside the columns of W is rounding. Noise that went through no such cable
has as much there as anywhere, and so has that of groups which begin one pixel later. The same of
columns tells whether rows share colours. Colours that were drawn as planes of whole codes have been
rounded once more, and there is two to four times as much outside.
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

TOP = 255
"""The highest code of a picture that went through such a cable."""

LARGEST = 4.0
"""What differences have outside W, in variances of rounding: codes that are rounded once more
between two colours add some to it."""

CLEAR = 1.0
"""By how much more groups that begin one pixel later leave, in variances of rounding."""

ROUNDED_TWICE = 1.5
"""The same from which colours were drawn in whole codes. With V of BT.601 1.402 times in red and
-0.714 in green, U -0.344 and 1.772, their rounding adds 2.4 times; half of that where every other
pixel shows a colour as it was carried."""

AS_LITTLE = 1.5
"""Times the least that any way leaves, up to which the one with the fewest colours is taken."""

NOTHING_DN2 = 1e-6
"""Colours that are repeated in whole codes leave nothing but errors of arithmetic."""

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
    """Which of `WAYS` these frames went, and how many rows share a colour; None where none.

    Where colours are drawn in lines, `taken` is 0 if they stand in the middle of a group, and
    `drawn` is 2 if they were rounded once more.

    Args:
        stacks: frames of lit shots, (N, H, W, 3) codes.
    """
    codes = [np.asarray(stack[:FRAMES]) for stack in stacks if stack.ndim == 4]
    rows = [_differences(one) for one in codes]
    left = [(_outside_of(rows, way), way) for way in WAYS]
    clear = [(here, way) for here, way in left if here is not None]
    if not clear:
        return None
    least = max(min(here for here, _ in clear), NOTHING_DN2)
    way = next(way for here, way in clear if here <= AS_LITTLE * least)
    if way["drawn"] and least > ROUNDED_TWICE * 2 * ROUNDING_DN2:
        way = {**way, "drawn": 2.0}
    of_columns = [_differences(one.swapaxes(1, 2)) for one in codes]
    down = _outside_of(of_columns, {**way, "mode": 1.0})
    return {**way, "rows": 1.0 if down is None else 2.0}


def _outside_of(lines: Sequence[Floats], way: Mapping[str, float]) -> float | None:
    """What lines of colour differences have outside of a way; None if it is more than rounding."""
    outside = _outside(_lines(way))
    here, later = (_left(lines, outside, shift) for shift in (0, 1))
    rounding = 2 * ROUNDING_DN2
    went = here < LARGEST * rounding and later > here + CLEAR * rounding
    return here if went else None


def _differences(codes: NDArray[Any]) -> Floats:
    """R - G and B - G of every row: (rows, columns); not a number where a code is clipped, as that
    is no sum of luma and colours."""
    clipped = ((codes == 0) | (codes == TOP)).any(axis=-1)
    green = np.where(clipped, np.nan, codes[..., 1].astype(np.float64))
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
        left = cut @ outside
        total += float(np.nansum(np.square(left)))
        count += int(np.isfinite(left).sum())
    return total / count if count else float("inf")
