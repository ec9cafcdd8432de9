"""The light as the blocks of the mean image see it.

Every twin and every step of a calibration asks for the same few, so that they are kept.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.camera.light import Light, Rate
from analysis.gap.look.observation import View
from analysis.gap.look.one_group import blocks

Floats = NDArray[np.float64]


def blocks_of(rate: Rate, view: View, channels: tuple[str, ...]) -> Floats:
    """Block means of an image (H, W, 3) at the measured samples: (channels, blocks)."""
    rows = []
    for channel in channels:
        images = []
        for lattice in view.lattices:
            if lattice.channel != channel:
                continue
            plane = rate[None] if channel != "Y" else rate[None, ..., 1]
            images.append(blocks(lattice.of(plane)[0], view.side).ravel())
        rows.append(np.mean(images, axis=0))
    return np.array(rows)


def lamp_dn(base: Base, light: Light, view: View, lamp: str) -> Floats:
    """What a lamp at level 1 shows in a second, in DN above black: (channels, blocks)."""
    dn_per_rate = base.level[lamp] * base.gain_dn_per_e
    return dn_per_rate[:, None] * _stated(light, view, base.channels, lamp)


KEPT = 8
"""Of each kind: lights of a few suspects, by lamp."""


def _kept(blocks: Floats) -> Floats:
    blocks.setflags(write=False)
    return blocks


@functools.lru_cache(maxsize=KEPT)
def _stated(light: Light, view: View, channels: tuple[str, ...], lamp: str) -> Floats:
    """Blocks of the rates of a lamp, as they were stated."""
    return _kept(blocks_of(light.rates[lamp], view, channels))


@functools.lru_cache(maxsize=KEPT)
def beyond_stated(light: Light, view: View, channels: tuple[str, ...], lamp: str) -> Floats:
    """Blocks of what a lamp shows beyond its stated rates, (channels, blocks)."""
    return _kept(blocks_of(light.falls[lamp] - light.rates[lamp], view, channels))


@functools.lru_cache(maxsize=KEPT)
def light_noise(light: Light, view: View, channels: tuple[str, ...]) -> Mapping[str, Floats]:
    """Relative variance of the light of each block by lamp: (channels, blocks)."""
    sites = [sum(one.channel == channel for one in view.lattices) for channel in channels]
    in_a_block = view.side**2 * np.array(sites, dtype=np.float64)[:, None]
    return {
        lamp: _kept(
            blocks_of(noise, view, channels)
            / in_a_block
            / np.square(np.maximum(_stated(light, view, channels, lamp), 1e-30))
        )
        for lamp, noise in light.noise.items()
    }
