"""Ways in which the light can differ from what is known of it, each with how far it may."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.camera.light import Light, Rate, lamp_of
from analysis.gap.camera.light_blocks import blocks_of, lamp_dn
from analysis.gap.camera.twin import NOT_CLIPPED, Scenery, exposure_of
from analysis.gap.look.lattices import BORDER_PX
from analysis.gap.look.observation import Observation, View
from foundation.panel import Panel

Floats = NDArray[np.float64]

FREE = np.inf
"""Prior of a way that nothing is known of."""

SHADING_PRIOR = 0.01
TINT_PRIOR = 0.005
TINTS = ((1.0, -0.5, -0.5), (0.0, 1.0, -1.0))
"""Of the same shading in one colour against others: filters and microlenses shade them differently,
by tenths of a percent where the lens is far away."""

PANEL_PRIOR = 0.01
LEVEL_PRIOR = 0.001
"""Of a shot's level against what the manifest states."""


Images = dict[str, Rate]
"""Rate images, or changes of them, by lamp."""


def _leave(images: Images, amount: float) -> None:
    """Change nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LightWay:
    """One way in which the light can differ.

    Attributes:
        means: change of the block means, (shots, channels, blocks).
        prior: standard deviation of its amount.
        add: so much of the same change to rate images, in place; of a level there is none.
    """

    means: Floats
    prior: float
    add: Callable[[Images, float], None] = _leave


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
    shown = {lamp: image.copy() for lamp, image in images.items()}
    for way, amount in zip(ways, amounts, strict=True):
        way.add(shown, float(amount))
    return dataclasses.replace(light, shown={k: np.maximum(v, 0.0) for k, v in shown.items()})


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
    """Changes of what a lamp that was stated shows: shading, place and reflectances."""
    unit = _units(base, scenery)
    lamps = tuple(unit)

    def everywhere(by_lamp: Mapping[str, Floats]) -> Floats:
        return _everywhere(by_lamp, scenery, reference)

    down, across = reference.grid
    y = np.repeat(np.linspace(-1, 1, down), across)
    x = np.tile(np.linspace(-1, 1, across), down)
    for k, of_blocks in enumerate(_shadings(x, y)):
        for lamp in lamps:
            yield LightWay(
                means=everywhere({lamp: unit[lamp] * of_blocks}),
                prior=SHADING_PRIOR,
                add=functools.partial(_shade, scenery, reference.grid, lamp, k, 1.0),
            )
            for tint in map(np.array, TINTS if len(base.channels) > 1 else ()):
                yield LightWay(
                    means=everywhere({lamp: tint[:, None] * unit[lamp] * of_blocks}),
                    prior=TINT_PRIOR,
                    add=functools.partial(_shade, scenery, reference.grid, lamp, k, tint),
                )
    blocks = _move_blocks(scenery.light, scenery.view, base.channels)
    for images, of_images in zip(_moves(scenery.light), blocks, strict=True):
        dn = {
            lamp: (base.level[lamp] * base.gain_dn_per_e)[:, None] * of_images[lamp]
            for lamp in lamps
        }
        yield LightWay(means=everywhere(dn), prior=FREE, add=functools.partial(_add, images))
    shape = scenery.body.height, scenery.body.width
    for panel in scenery.light.panels:
        where = _inside(panel, shape, scenery.view, base.channels)
        for c in range(len(base.channels)):
            one = np.zeros_like(where)
            one[c] = where[c]
            yield LightWay(
                means=everywhere({lamp: unit[lamp] * one for lamp in lamps}),
                prior=PANEL_PRIOR,
                add=functools.partial(_brighten, scenery, lamps, base.channels[c], panel),
            )


@functools.lru_cache(maxsize=2)
def _moves(light: Light) -> tuple[Images, ...]:
    """Changes of what lamps show where the picture lies elsewhere: every step of a calibration asks
    for them."""
    return tuple(
        {lamp: moved(rate) for lamp, rate in light.rates.items()}
        for moved in (_across, _down, _scaled, _turned)
    )


@functools.lru_cache(maxsize=4)
def _move_blocks(
    light: Light, view: View, channels: tuple[str, ...]
) -> tuple[Mapping[str, Floats], ...]:
    """Blocks of these changes by lamp, (channels, blocks)."""
    return tuple(
        {lamp: blocks_of(image, view, channels) for lamp, image in images.items()}
        for images in _moves(light)
    )


@functools.lru_cache(maxsize=128)
def _inside(
    panel: Panel | None, shape: tuple[int, int], view: View, channels: tuple[str, ...]
) -> Floats:
    """Part of each block that lies in a panel, (channels, blocks)."""
    mask = np.zeros((*shape, 3), dtype=np.float32)
    mask[_area(panel)] = 1.0
    return blocks_of(mask, view, channels)


def _shadings(x: Floats, y: Floats) -> tuple[Floats, ...]:
    return x, y, x * x, x * y, y * y


def _shade(
    scenery: Scenery,
    grid: tuple[int, int],
    lamp: str,
    k: int,
    tint: Floats | float,
    images: Images,
    amount: float,
) -> None:
    """Add the light of a lamp times the k-th shading."""
    pitch_px = scenery.view.side * scenery.view.lattices[0].step
    rate = scenery.light.rates[lamp]
    shading = _shading_images(rate.shape[:2], grid, pitch_px)[k]
    images[lamp] += rate * (shading * np.float32(amount * tint))


@functools.lru_cache(maxsize=2)
def _shading_images(shape: tuple[int, int], grid: tuple[int, int], pitch_px: int) -> list[Rate]:
    """The shadings in every pixel, (H, W, 1) each; 1 in the middle of the last block."""

    def along(size_px: int, blocks: int) -> Floats:
        at = (np.arange(size_px) + 0.5 - BORDER_PX) / pitch_px - 0.5
        return np.asarray(2.0 * at / max(blocks - 1, 1) - 1.0)

    y, x = np.meshgrid(along(shape[0], grid[0]), along(shape[1], grid[1]), indexing="ij")
    return [one.astype(np.float32)[..., None] for one in _shadings(x, y)]


def _area(panel: Panel | None) -> tuple[slice, ...]:
    """Rows and columns of a panel; all of them where there is none."""
    if panel is None:
        return slice(None), slice(None)
    return slice(panel.y, panel.y + panel.h), slice(panel.x, panel.x + panel.w)


def _brighten(
    scenery: Scenery,
    lamps: Sequence[str],
    channel: str,
    panel: Panel | None,
    images: Images,
    amount: float,
) -> None:
    """Add light in one channel, of a panel or all of it; a grey camera has all colours in one."""
    colours = slice(None) if channel == "Y" else "RGB".index(channel)
    area = (*_area(panel), colours)
    for lamp in lamps:
        images[lamp][area] += np.float32(amount) * scenery.light.rates[lamp][area]


def _add(changes: Images, images: Images, amount: float) -> None:
    for lamp, change in changes.items():
        images[lamp] += np.float32(amount) * change


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
