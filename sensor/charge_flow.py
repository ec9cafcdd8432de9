"""Charge that moves between neighbouring photosites without getting lost at the border."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr

from sensor.neighbours import Neighbours
from sensor.signal import Signal

BESIDE = ((0, -1), (0, 1), (-1, 0), (1, 0))
"""The four nearest neighbours, (dy, dx)."""

AROUND = (*BESIDE, (-1, -1), (-1, 1), (1, -1), (1, 1))
"""These and the four at the corners."""


def exists(near: Neighbours, dy: int, dx: int) -> Any:
    """Whether the pixel dy below and dx to the right lies on the sensor: flat mask."""
    signed = dr.int32_array_t(type(near.row))
    y, x = signed(near.row) + dy, signed(near.column) + dx
    return (y >= 0) & (y < near.shape[1]) & (x >= 0) & (x < near.shape[2])


def after_exchange(
    signal: Signal,
    inflow: Callable[[Any, Any, int, int], Any],
    neighbours: Sequence[tuple[int, int]] = BESIDE,
    free: Signal | None = None,
) -> Any:
    """The charge of every pixel after an exchange with its neighbours, as a tensor.

    Args:
        signal: charge, (f, H, W).
        inflow: charge that a pixel gets from a neighbour, from (own charge, neighbour's charge,
            dy, dx); antisymmetric in the charges, so that nothing is made or lost.
        neighbours: where they are, each with the one on the other side.
        free: the part of the charge that is exchanged, where that is not all of it.
    """
    near = Neighbours(free or signal)
    own = near.flat
    total = signal.value.array if free else own
    for dy, dx in neighbours:
        gained = inflow(own, near.flat_at(dy, dx), dy, dx)
        total = total + dr.select(exists(near, dy, dx), gained, 0.0)
    return near.tensor(total, signal.shape)
