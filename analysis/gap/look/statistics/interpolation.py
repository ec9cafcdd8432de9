"""What a demosaicer and the processing after it leave: interpolated samples against measured ones.

Also the grid of 8 x 8 blocks that a codec leaves, on the whole image.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice, of_a_mosaic
from analysis.gap.look.statistics.group import Figures, Floats, lagged, safe_ratio

MOST_ROWS = 240
"""Rows that are looked at, in the middle of the image and from the start of a block."""


def interpolation(dn: NDArray[Any], lattices: tuple[Lattice, ...]) -> Figures:
    """Figures of colour images; of the block grid alone for others. Each is one number.

    Args:
        dn: frames, (n, H, W, 3) or (n, H, W).
        lattices: where the measured samples are.
    """
    colour = dn.ndim == 4
    start = max(0, dn.shape[1] - MOST_ROWS) // 2 // 8 * 8
    dn = dn[:2, start : start + MOST_ROWS]
    first, second = (cv2.split(frame) if colour else [frame] for frame in dn)
    green = np.ascontiguousarray(first[1 if colour else 0])
    found = {"grid of 8, across": _grid(green), "grid of 8, down": _grid(cv2.transpose(green))}
    if not colour:
        return found
    noise = [_less(one, other) for one, other in zip(first, second, strict=True)]
    if of_a_mosaic(lattices):
        found |= _against_bilinear(first, noise, lattices)
    width = green.shape[1]
    for name, k in (("R", 0), ("B", 2)):
        side = _less(noise[k], noise[1]).ravel()
        v = lagged(side, 0)
        for lag in (1, 2, 4):
            found[f"colour noise {name}, across {lag}"] = safe_ratio(lagged(side, lag), v)
        found[f"colour noise {name}, down 1"] = safe_ratio(lagged(side, width), v)
    power = [lagged(plane.ravel(), 0) for plane in noise]
    for a, b in ((0, 1), (1, 2), (0, 2)):
        together = np.vecdot(noise[a].ravel(), noise[b].ravel()) / green.size
        scale = np.sqrt(power[a] * power[b])
        found[f"noise of {'RGB'[a]} with {'RGB'[b]}"] = safe_ratio(together, scale)
    return found


def _against_bilinear(
    planes: Sequence[NDArray[Any]],
    noise: Sequence[NDArray[np.float32]],
    lattices: tuple[Lattice, ...],
) -> Figures:
    """How far red and blue, where green was measured, are from the mean of their neighbours."""
    found: Figures = {}
    for lattice in lattices:
        if lattice.channel == "G":
            continue
        plane = planes["RGB".index(lattice.channel)]
        rows = plane[lattice.dy :: 2].astype(np.float32)
        own, between = rows[:, lattice.dx :: 2], rows[:, 1 - lattice.dx :: 2]
        left, right = (own[:, :-1], own[:, 1:])
        start = 0 if lattice.dx == 0 else 1
        at = between[:, start : start + left.shape[1]]
        n = min(at.shape[1], left.shape[1])
        off = at[:, :n] - (left[:, :n] + right[:, :n]) / 2
        found[f"off bilinear {lattice.channel}"] = np.log(np.square(off).mean() + 0.05)
        channel = noise["RGB".index(lattice.channel)]
        measured = np.square(channel[lattice.dy :: 2, lattice.dx :: 2]).mean()
        beside = np.square(channel[lattice.dy :: 2, 1 - lattice.dx :: 2]).mean()
        corner = np.square(channel[1 - lattice.dy :: 2, 1 - lattice.dx :: 2]).mean()
        found[f"interpolated noise {lattice.channel}"] = safe_ratio(beside, measured)
        found[f"doubly interpolated noise {lattice.channel}"] = safe_ratio(corner, measured)
    return found


def _less(one: NDArray[Any], other: NDArray[Any]) -> NDArray[np.float32]:
    return np.asarray(cv2.subtract(one, other, dtype=cv2.CV_32F), dtype=np.float32)


def _grid(plane: NDArray[Any]) -> Floats:
    """Steps across the borders of 8 x 8 blocks over steps elsewhere, less 1."""
    steps = cv2.absdiff(plane[:, 1:], plane[:, :-1])
    most = 8 * float(np.median(steps[::8, ::3])) + 4
    by_column = cv2.reduce(cv2.min(steps, most), 0, cv2.REDUCE_SUM, dtype=cv2.CV_64F)[0]
    return safe_ratio(by_column[7::8].mean(), by_column.mean()) - 1.0
