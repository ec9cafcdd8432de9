"""Where a soft patch of light lies, by what a model leaves of the picture.

Calibration takes up whatever of a patch is like shading, and what is left of a wide one is a ring
of bright corners about nothing. So each place and size is tried as it would be left. A patch in
every shot is one picture p of blocks times an amplitude of each shot and channel, in units of
standard errors v = w p, and with the projection Q of what calibration takes up

    gain(p) = (p . w'r)^2 / (p^2 . |w|^2 - |p' w'Q|^2),

so that sums over shots and channels are made once for all places.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_blocks import blocks_of, lamp_dn
from analysis.gap.camera.twin import Scenery, exposure_of
from analysis.gap.measure.case import Case

Floats = NDArray[np.float64]

SIZES = 10
"""Sizes that are tried, from half of a block to half of the image's height."""

FINER = 2
"""Places that are tried to a block, along each side."""


LEAST_LEFT = 1e-3
"""Part of a patch that is left at least: below that there are only errors of arithmetic."""

LEAST_GAIN = 24.0
"""What a patch must take off chi-squared. The best of n places and sizes takes off some 2 ln n by
chance, which is 11 of some 300 that have little in common. Of 300 draws of noise a tenth had more
than 13, a hundredth more than 19, and none 24."""


@dataclass(frozen=True, kw_only=True)
class Lobe:
    """A patch with the profile of a normal distribution.

    Attributes:
        x_px, y_px: its middle, from the upper left corner of the image.
        sigma_px: its standard deviation.
    """

    x_px: float
    y_px: float
    sigma_px: float


def lobe_of(case: Case) -> Lobe | None:
    """The patch of light that would take most off chi-squared of the frames that fit.

    None where the best of all places is no better than chance makes it.
    """
    turned, scenery = case.fitting.turned, case.known.scenery
    shots, channels, blocks = turned.space.shape
    lobes = _lobes(scenery)
    profiles = _on_blocks(lobes, scenery, case.known.base.channels)
    flat = turned.space.blocks(np.repeat(_amplitudes(case)[..., None], blocks, axis=-1))
    of_image = slice(len(turned.space.keys), len(turned.space.keys) + flat.size)
    w = flat.reshape(shots * channels, blocks)
    left = case.fit_left[of_image].reshape(w.shape)
    q = turned.q[of_image].reshape(*w.shape, -1)
    along = profiles @ np.einsum("kb,kb->b", w, left)
    taken_up = profiles @ np.einsum("kb,kbn->bn", w, q)
    whole = np.square(profiles) @ np.einsum("kb,kb->b", w, w)
    norm = np.maximum(whole - np.square(taken_up).sum(axis=1), LEAST_LEFT * whole)
    gain = np.square(np.maximum(along, 0.0)) / np.maximum(norm, 1e-300)
    best = int(np.argmax(gain))
    return lobes[best] if gain[best] > LEAST_GAIN else None


def _lobes(scenery: Scenery) -> list[Lobe]:
    height, width, block = scenery.body.height, scenery.body.width, _block_px(scenery)
    pitch = block / FINER
    return [
        Lobe(x_px=float(x), y_px=float(y), sigma_px=float(sigma))
        for sigma in np.geomspace(0.5 * block, 0.5 * height, SIZES)
        for y in np.arange(0.5 * pitch, height, pitch)
        for x in np.arange(0.5 * pitch, width, pitch)
    ]


def _block_px(scenery: Scenery) -> int:
    return scenery.view.side * scenery.view.lattices[0].step


def _on_blocks(lobes: Sequence[Lobe], scenery: Scenery, channels: tuple[str, ...]) -> Floats:
    """Each lobe as the blocks see it, up to a factor, (lobes, blocks).

    The mean of a normal profile over a block of side d is all but normal, with the variance
    sigma^2 + d^2 / 12.
    """
    place = np.indices((scenery.body.height, scenery.body.width), dtype=np.float32) + 0.5
    y, x = (
        blocks_of(np.repeat(one[..., None], 3, axis=-1), scenery.view, channels).mean(axis=0)
        for one in place
    )
    middles = np.array([(lobe.y_px, lobe.x_px) for lobe in lobes])
    variances = np.square([lobe.sigma_px for lobe in lobes]) + _block_px(scenery) ** 2 / 12
    off = np.square(y - middles[:, :1]) + np.square(x - middles[:, 1:])
    return np.asarray(np.exp(-0.5 * off / variances[:, None]))


def _amplitudes(case: Case) -> Floats:
    """Light of a patch that is as bright as the scene in the mean, in DN, (shots, channels)."""
    base, scenery = case.known.base, case.known.scenery
    found = np.zeros((len(scenery.shots), len(base.channels)))
    for k, shot in enumerate(scenery.shots):
        if not shot.dark:
            one = lamp_dn(base, scenery.light, scenery.view, lamp_of(shot))
            found[k] = exposure_of(shot) * one.mean(axis=1)
    return found
