"""Ways in which the light can differ from what is known of it, each with how far it may."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.camera.light import Light, Rate, lamp_of
from analysis.gap.camera.light_blocks import blocks_of, lamp_dn
from analysis.gap.camera.light_images import (
    PLACES,
    Amounts,
    area_of,
    bend,
    brighten,
    move,
    moves,
    shade,
    shadings,
    with_amounts,
)
from analysis.gap.camera.surface import SHAPES, laid
from analysis.gap.camera.twin import NOT_CLIPPED, Scenery, exposure_of
from analysis.gap.look.observation import Observation, View
from foundation.panel import Panel

Floats = NDArray[np.float64]

FREE = np.inf
"""Prior of a way that nothing is known of."""

SHADING_PRIOR = 0.01
"""Of each shading of a lamp, as a part of the light at the edge of the picture: an assumption."""

TINT_PRIOR = 0.005
"""Of a shading that colours do not share, in the same parts: an assumption; see `TINTS`."""

TINTS = ((1.0, -0.5, -0.5), (0.0, 1.0, -1.0))
"""Of the same shading in one colour against others: filters and microlenses shade them differently,
by tenths of a percent where the lens is far away."""

PANEL_PRIOR = 0.01
"""Of a panel's reflectance in each channel, as a part, shared by all lamps: an assumption."""

LEVEL_PRIOR = 0.001
"""Of a shot's level against what the manifest states."""


def _leave(amounts: Amounts, amount: float) -> None:
    """Change nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LightWay:
    """One way in which the light can differ.

    Attributes:
        means: change of the block means, (shots, channels, blocks).
        prior: standard deviation of its amount.
        add: so much of the same change to that of rate images; of a level there is none.
    """

    means: Floats
    prior: float
    add: Callable[[Amounts, float], None] = _leave


def changed(
    light: Light, images: Mapping[str, Rate], ways: Iterable[LightWay], amounts: Floats
) -> Light:
    """Light that frames show as rate images with so much of each way.

    Args:
        light: as it was stated.
        images: to begin with, by lamp.
        ways: in which it differs.
        amounts: of each.
    """
    total = Amounts()
    for way, amount in zip(ways, amounts, strict=True):
        way.add(total, float(amount))
    shown = {lamp: with_amounts(light, lamp, image, total) for lamp, image in images.items()}
    return dataclasses.replace(light, shown=shown)


def level_ways(
    base: Base, scenery: Scenery, reference: Observation
) -> Iterator[tuple[str, int, LightWay]]:
    """Changes of the level of each lamp in each channel, of which nothing is known beforehand.

    Yields:
        the lamp, the channel, and what a level that is higher by a part of it does.
    """
    for lamp, dn in _units(base, scenery).items():
        for channel in range(len(base.channels)):
            one = np.zeros_like(dn)
            one[channel] = dn[channel]
            means = _everywhere({lamp: one}, scenery, reference)
            yield lamp, channel, LightWay(means=means, prior=FREE)


def _units(base: Base, scenery: Scenery) -> dict[str, Floats]:
    """What each lamp shows at level 1 in a second, in DN; see `lamp_dn`."""
    lamps = sorted({lamp_of(shot) for shot in scenery.shots if not shot.dark})
    return {lamp: lamp_dn(base, scenery.light, scenery.view, lamp) for lamp in lamps}


def _everywhere(by_lamp: Mapping[str, Floats], scenery: Scenery, reference: Observation) -> Floats:
    """Changes of what lamps show in a second, as changes of all shots where nothing is clipped."""
    change = np.zeros(reference.means.shape[1:])
    for k, shot in enumerate(scenery.shots):
        if not shot.dark and lamp_of(shot) in by_lamp:
            change[k] = by_lamp[lamp_of(shot)] * exposure_of(shot)
    return _unclipped(change, scenery, reference)


def _unclipped(change: Floats, scenery: Scenery, reference: Observation) -> Floats:
    """A change of block means, (shots, channels, blocks), where these are not clipped."""
    shows = reference.means.mean(axis=0) < NOT_CLIPPED * scenery.view.top_dn
    return np.where(shows, change, 0.0)


def light_ways(base: Base, scenery: Scenery, reference: Observation) -> Iterator[LightWay]:
    """Changes of the light alone, each with its prior."""
    yield from shot_ways(base, scenery, reference)
    if scenery.light.known:
        yield from image_ways(base, scenery, reference)


def shot_ways(base: Base, scenery: Scenery, reference: Observation) -> Iterator[LightWay]:
    """Changes of the level of each shot against what the manifest states."""
    unit = _units(base, scenery)
    for k, shot in enumerate(scenery.shots):
        if shot.dark:
            continue
        change = np.zeros(reference.means.shape[1:])
        change[k] = unit[lamp_of(shot)] * exposure_of(shot)
        yield LightWay(means=_unclipped(change, scenery, reference), prior=LEVEL_PRIOR)


def image_ways(base: Base, scenery: Scenery, reference: Observation) -> Iterator[LightWay]:
    """Changes of what a lamp shows, of one that was stated or of a surface through the frames."""
    ways = surface_ways if scenery.light.drawn else stated_ways
    return ways(base, scenery, reference)


def surface_ways(base: Base, scenery: Scenery, reference: Observation) -> Iterator[LightWay]:
    """Changes of a surface that was laid through the frames: any other may be the light."""
    size = scenery.body.height, scenery.body.width
    shapes = _shape_blocks(size, scenery.view, base.channels)
    for lamp in _units(base, scenery):
        dn_per_rate = base.level[lamp] * base.gain_dn_per_e
        for k in range(1, SHAPES):
            for c, channel in enumerate(base.channels):
                one = np.zeros_like(shapes[k])
                one[c] = dn_per_rate[c] * shapes[k, c]
                yield LightWay(
                    means=_everywhere({lamp: one}, scenery, reference),
                    prior=FREE,
                    add=functools.partial(bend, lamp, k, channel),
                )


@functools.lru_cache(maxsize=4)
def _shape_blocks(size: tuple[int, int], view: View, channels: tuple[str, ...]) -> Floats:
    """Blocks of the shapes of a surface, (shapes, channels, blocks)."""
    images = (laid(one[:, None], size).astype(np.float32) for one in np.eye(SHAPES))
    alike = (np.broadcast_to(image, (*size, 3)) for image in images)
    return np.array([blocks_of(image, view, channels) for image in alike])


def stated_ways(base: Base, scenery: Scenery, reference: Observation) -> Iterator[LightWay]:
    """Changes of what a lamp that was stated shows: shading, place and reflectances."""
    unit = _units(base, scenery)
    lamps = tuple(unit)

    def everywhere(by_lamp: Mapping[str, Floats]) -> Floats:
        return _everywhere(by_lamp, scenery, reference)

    down, across = reference.grid
    grid = (down, across, scenery.view.side * scenery.view.lattices[0].step)
    y = np.repeat(np.linspace(-1, 1, down), across)
    x = np.tile(np.linspace(-1, 1, across), down)
    for k, of_blocks in enumerate(shadings(x, y)):
        for lamp in lamps:
            yield LightWay(
                means=everywhere({lamp: unit[lamp] * of_blocks}),
                prior=SHADING_PRIOR,
                add=functools.partial(shade, lamp, grid, k, 1.0),
            )
            for tint in map(np.array, TINTS if len(base.channels) > 1 else ()):
                yield LightWay(
                    means=everywhere({lamp: tint[:, None] * unit[lamp] * of_blocks}),
                    prior=TINT_PRIOR,
                    add=functools.partial(shade, lamp, grid, k, tint),
                )
    blocks = _move_blocks(scenery.light, scenery.view, base.channels)
    for k in range(PLACES):
        dn = {
            lamp: (base.level[lamp] * base.gain_dn_per_e)[:, None] * blocks[lamp][k]
            for lamp in lamps
        }
        yield LightWay(means=everywhere(dn), prior=FREE, add=functools.partial(move, k))
    shape = scenery.body.height, scenery.body.width
    for panel in scenery.light.panels:
        where = _inside(panel, shape, scenery.view, base.channels)
        for c in range(len(base.channels)):
            one = np.zeros_like(where)
            one[c] = where[c]
            yield LightWay(
                means=everywhere({lamp: unit[lamp] * one for lamp in lamps}),
                prior=PANEL_PRIOR,
                add=functools.partial(brighten, base.channels[c], panel),
            )


@functools.lru_cache(maxsize=4)
def _move_blocks(light: Light, view: View, channels: tuple[str, ...]) -> Mapping[str, Floats]:
    """Blocks of these changes by lamp, (moves, channels, blocks)."""
    return {
        lamp: np.array([blocks_of(image, view, channels) for image in images])
        for lamp, images in moves(light).items()
    }


@functools.lru_cache(maxsize=128)
def _inside(
    panel: Panel | None, shape: tuple[int, int], view: View, channels: tuple[str, ...]
) -> Floats:
    """Part of each block that lies in a panel, (channels, blocks)."""
    mask = np.zeros((*shape, 3), dtype=np.float32)
    mask[area_of(panel)] = 1.0
    return blocks_of(mask, view, channels)
