"""The light as the blocks of the mean image see it."""

from __future__ import annotations

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
    return dn_per_rate[:, None] * blocks_of(light.rates[lamp], view, base.channels)


def light_noise(light: Light, view: View, channels: tuple[str, ...]) -> dict[str, Floats]:
    """Relative variance of the light of each block by lamp: (channels, blocks)."""
    sites = [sum(one.channel == channel for one in view.lattices) for channel in channels]
    in_a_block = view.side**2 * np.array(sites, dtype=np.float64)[:, None]
    return {
        lamp: blocks_of(noise, view, channels)
        / in_a_block
        / np.square(np.maximum(blocks_of(light.rates[lamp], view, channels), 1e-30))
        for lamp, noise in light.noise.items()
    }
