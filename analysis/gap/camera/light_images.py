"""Rate images with so much of each way in which light can differ.

A way is added as a number. Images are changed once, by all of them.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.light import Light, Rate
from analysis.gap.camera.surface import SHAPES, laid
from analysis.gap.look.lattices import BORDER_PX
from foundation.panel import Panel

Floats = NDArray[np.float64]

Grid = tuple[int, int, int]
"""Blocks down and across, and their pitch in pixels."""

SHADINGS = 5
PLACES = 4
"""How many shadings there are, and places where the picture may lie instead."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Amounts:
    """How much of each way there is in a light, added up way by way.

    Attributes:
        shading: of each shading in each colour, (shadings, 3), by lamp and by the grid that they
            are laid on; see `_shading_images`.
        bent: of each shape of a surface in each colour, (shapes, 3), by lamp.
        moved: of each place where the picture may lie instead.
        brighter: parts by which areas and colours are brighter.
    """

    shading: dict[tuple[str, Grid], Floats] = dataclasses.field(default_factory=dict)
    bent: dict[str, Floats] = dataclasses.field(default_factory=dict)
    moved: Floats = dataclasses.field(default_factory=lambda: np.zeros(PLACES))
    brighter: list[tuple[tuple[slice | int, ...], float]] = dataclasses.field(default_factory=list)


def shade(lamp: str, grid: Grid, k: int, tint: Floats | float, to: Amounts, amount: float) -> None:
    """Add the light of a lamp times the k-th shading."""
    to.shading.setdefault((lamp, grid), np.zeros((SHADINGS, 3)))[k] += amount * tint


def bend(lamp: str, k: int, channel: str, to: Amounts, amount: float) -> None:
    """Add the k-th shape of a surface to what a lamp shows in one channel."""
    to.bent.setdefault(lamp, np.zeros((SHAPES, 3)))[k, colours_of(channel)] += amount


def brighten(channel: str, panel: Panel | None, to: Amounts, amount: float) -> None:
    """Add light in one channel, of a panel or all of it."""
    to.brighter.append(((*area_of(panel), colours_of(channel)), amount))


def move(k: int, to: Amounts, amount: float) -> None:
    """Add the k-th change of where the picture lies."""
    to.moved[k] += amount


def with_amounts(light: Light, lamp: str, image: Rate, amounts: Amounts) -> Rate:
    """The rate image of a lamp with so much of each way; no rate is below 0."""
    rate = light.rates[lamp]
    made = np.tensordot(amounts.moved.astype(np.float32), moves(light)[lamp], axes=1) + image
    for (which, grid), of_each in amounts.shading.items():
        if which == lamp:
            made += rate * (_shading_images(rate.shape[:2], grid) @ of_each.astype(np.float32))
    if lamp in amounts.bent:
        made += laid(amounts.bent[lamp], rate.shape[:2]).astype(np.float32)
    for area, amount in amounts.brighter:
        made[area] += np.float32(amount) * rate[area]
    return np.asarray(np.maximum(made, 0.0, out=made))


def shadings(x: Floats, y: Floats) -> tuple[Floats, ...]:
    """Of places from -1 to 1: slopes and bends."""
    return x, y, x * x, x * y, y * y


@functools.lru_cache(maxsize=2)
def _shading_images(shape: tuple[int, int], grid: Grid) -> Rate:
    """The shadings in every pixel, (H, W, shadings); 1 in the middle of the last block."""
    down, across, pitch_px = grid

    def along(size_px: int, blocks: int) -> Floats:
        at = (np.arange(size_px) + 0.5 - BORDER_PX) / pitch_px - 0.5
        return np.asarray(2.0 * at / max(blocks - 1, 1) - 1.0)

    y, x = np.meshgrid(along(shape[0], down), along(shape[1], across), indexing="ij")
    return np.stack([one.astype(np.float32) for one in shadings(x, y)], axis=-1)


def colours_of(channel: str) -> slice | int:
    """Which colours of a rate image a channel shows; a grey camera has all in one."""
    return slice(None) if channel == "Y" else "RGB".index(channel)


def area_of(panel: Panel | None) -> tuple[slice, ...]:
    """Rows and columns of a panel; all of them where there is none."""
    if panel is None:
        return slice(None), slice(None)
    return slice(panel.y, panel.y + panel.h), slice(panel.x, panel.x + panel.w)


@functools.lru_cache(maxsize=2)
def moves(light: Light) -> Mapping[str, Rate]:
    """Changes of what lamps show where the picture lies elsewhere, (moves, H, W, 3) by lamp: every
    step of a calibration asks for them."""
    return {lamp: np.array([one(rate) for one in _MOVES]) for lamp, rate in light.rates.items()}


def _across(rate: Rate) -> Rate:
    return np.asarray(np.gradient(rate, axis=1))


def _down(rate: Rate) -> Rate:
    return np.asarray(np.gradient(rate, axis=0))


def _about_the_middle(rate: Rate) -> tuple[Rate, Rate]:
    """Places in widths, right of and below the middle."""
    h, w = rate.shape[:2]
    y = (np.arange(h, dtype=np.float32) - h / 2)[:, None, None] / w
    x = (np.arange(w, dtype=np.float32) - w / 2)[None, :, None] / w
    return x, y


def _scaled(rate: Rate) -> Rate:
    x, y = _about_the_middle(rate)
    return np.asarray(x * _across(rate) + y * _down(rate))


def _turned(rate: Rate) -> Rate:
    x, y = _about_the_middle(rate)
    return np.asarray(x * _down(rate) - y * _across(rate))


_MOVES: tuple[Callable[[Rate], Rate], ...] = (_across, _down, _scaled, _turned)
