"""Ways in which the light can differ from what is known of it, each with how far it may."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_blocks import blocks_of, lamp_dn
from analysis.gap.camera.twin import Scenery, exposure_of
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]

FREE = np.inf
"""Prior of a way that nothing is known of."""

SHADING_PRIOR = 0.01
PANEL_PRIOR = 0.01
LEVEL_PRIOR = 0.001
"""Of a shot's level against what the manifest states."""


def light_ways(
    base: Base, scenery: Scenery, reference: Observation
) -> Iterator[tuple[Floats, float]]:
    """Changes of the block means by the light alone, each with its prior."""
    shape = reference.means.shape[1:]
    lit = [k for k, shot in enumerate(scenery.shots) if not shot.dark]
    lamps = sorted({lamp_of(scenery.shots[k]) for k in lit})
    unit = {lamp: lamp_dn(base, scenery.light, scenery.view, lamp) for lamp in lamps}
    for k in lit:
        change = np.zeros(shape)
        shot = scenery.shots[k]
        change[k] = unit[lamp_of(shot)] * exposure_of(shot)
        yield change, LEVEL_PRIOR
    if not scenery.light.known:
        return

    def everywhere(by_lamp: dict[str, Floats]) -> Floats:
        change = np.zeros(shape)
        for k in lit:
            shot = scenery.shots[k]
            if lamp_of(shot) in by_lamp:
                change[k] = by_lamp[lamp_of(shot)] * exposure_of(shot)
        return change

    down, across = reference.grid
    y = np.repeat(np.linspace(-1, 1, down), across)
    x = np.tile(np.linspace(-1, 1, across), down)
    for shading in (x, y, x * x, x * y, y * y):
        for lamp in lamps:
            yield everywhere({lamp: unit[lamp] * shading}), SHADING_PRIOR
    yield from ((everywhere(change), FREE) for change in _moved(base, scenery, lamps))
    height, width = scenery.body.height, scenery.body.width
    for panel in scenery.light.panels:
        mask = np.zeros((height, width, 3), dtype=np.float32)
        mask[panel.y : panel.y + panel.h, panel.x : panel.x + panel.w] = 1.0
        where = blocks_of(mask, scenery.view, base.channels)
        for c in range(len(base.channels)):
            one = np.zeros_like(where)
            one[c] = where[c]
            yield everywhere({lamp: unit[lamp] * one for lamp in lamps}), PANEL_PRIOR


def _moved(base: Base, scenery: Scenery, lamps: list[str]) -> Iterator[dict[str, Floats]]:
    """The picture shifted, turned and scaled, by lamp."""
    pieces: list[dict[str, Floats]] = [{} for _ in range(4)]
    for lamp in lamps:
        rate = scenery.light.rates[lamp].astype(np.float32)
        dy, dx = np.gradient(rate, axis=(0, 1))
        h, w = rate.shape[:2]
        y = (np.arange(h, dtype=np.float32) - h / 2)[:, None, None] / w
        x = (np.arange(w, dtype=np.float32) - w / 2)[None, :, None] / w
        scale = (base.level[lamp] * base.gain_dn_per_e)[:, None]
        for piece, image in zip(pieces, (dx, dy, x * dx + y * dy, x * dy - y * dx), strict=True):
            piece[lamp] = scale * blocks_of(image, scenery.view, base.channels)
    yield from pieces
