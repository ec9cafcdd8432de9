"""Where a soft patch of light lies, by what a model leaves of the picture.

Calibration takes up whatever of a patch is like shading, and what is left of a wide one is a ring
of bright corners about nothing. So each place and size is tried as it would be left. A patch in
every shot is one picture p of blocks times an amplitude of each shot and channel, in units of
standard errors v = w p, and with the projection Q of what calibration takes up

    gain(p) = (p . w'r)^2 / (p^2 . |w|^2 - |p' w'Q|^2),

so that sums over shots and channels are made once for all places. From the best of them steps lead
to an ellipse, where that is more than chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import fmin

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


LEAST_FOR_A_SHAPE = 18.4
"""What an ellipse must take off chi-squared beyond the best circle: two figures more do so once in
10,000 times."""

MOST_STRETCHED = 8.0
"""Length over width of a patch, at most: as far as the effect goes."""

SHAPES = ((0.9, 0.0), (0.0, 0.9), (-0.9, 0.0), (0.0, -0.9))
"""Where a search for a shape begins: two and a half times as long as wide, along rows, columns and
both diagonals; see `_moved`."""

STEPS = 300
"""Of such a search, at most."""


@dataclass(frozen=True, kw_only=True)
class Lobe:
    """A patch with the profile of a normal distribution.

    Attributes:
        x_px, y_px: its middle, from the upper left corner of the image.
        sigma_px: its standard deviation, of an ellipse the geometric mean of both.
        longer: length over width.
        slant_deg: from a row, downwards, to its longer axis.
    """

    x_px: float
    y_px: float
    sigma_px: float
    longer: float = 1.0
    slant_deg: float = 0.0


def lobe_of(case: Case) -> Lobe | None:
    """The patch of light that would take most off chi-squared of the frames that fit.

    None where the best of all places is no better than chance makes it.
    """
    gain_of = _gains(case)
    lobes = _lobes(case.known.scenery)
    gains = gain_of(lobes)
    best = int(np.argmax(gains))
    if gains[best] <= LEAST_GAIN:
        return None
    circle = _moved(lobes[best], gain_of)
    # a circle may lie across one end of an ellipse, from where no step leads along it
    ellipses = [_moved(lobes[best], gain_of, shape) for shape in SHAPES]
    of_circle, *of_ellipses = gain_of([circle, *ellipses])
    likeliest = int(np.argmax(of_ellipses))
    needed = of_ellipses[likeliest] > of_circle + LEAST_FOR_A_SHAPE
    return ellipses[likeliest] if needed else lobes[best]


def _gains(case: Case) -> Callable[[Sequence[Lobe]], Floats]:
    """By how much each patch of some would take chi-squared down."""
    turned, scenery = case.fitting.turned, case.known.scenery
    shots, channels, blocks = turned.space.shape
    flat = turned.space.blocks(np.repeat(_amplitudes(case)[..., None], blocks, axis=-1))
    of_image = slice(len(turned.space.keys), len(turned.space.keys) + flat.size)
    w = flat.reshape(shots * channels, blocks)
    left = case.fit_left[of_image].reshape(w.shape)
    q = turned.q[of_image].reshape(*w.shape, -1)
    of_left, of_itself = np.einsum("kb,kb->b", w, left), np.einsum("kb,kb->b", w, w)
    taken_up = np.einsum("kb,kbn->bn", w, q)
    place = _places(scenery, case.known.base.channels)

    def gain_of(lobes: Sequence[Lobe]) -> Floats:
        profiles = _on_blocks(lobes, place, _block_px(scenery))
        along = profiles @ of_left
        whole = np.square(profiles) @ of_itself
        norm = np.maximum(whole - np.square(profiles @ taken_up).sum(axis=1), LEAST_LEFT * whole)
        return np.asarray(np.square(np.maximum(along, 0.0)) / np.maximum(norm, 1e-300))

    return gain_of


def _moved(
    begun: Lobe,
    gain_of: Callable[[Sequence[Lobe]], Floats],
    shape: tuple[float, float] | tuple[()] = (),
) -> Lobe:
    """The patch to which small steps lead: its middle, its size and, if it begins with one, its
    shape.

    A shape is ln l (cos 2a, sin 2a) for a length l and a slant a, which has no pole at a circle.
    """

    def lobe(figures: Floats) -> Lobe:
        x, y, size, *of_shape = figures
        one, other = of_shape or (0.0, 0.0)
        longer = min(float(np.exp(np.hypot(one, other))), MOST_STRETCHED)
        return Lobe(
            x_px=begun.x_px + begun.sigma_px * float(x),
            y_px=begun.y_px + begun.sigma_px * float(y),
            sigma_px=begun.sigma_px * float(np.exp(size)),
            longer=longer,
            slant_deg=float(np.degrees(np.arctan2(other, one)) / 2),
        )

    start = np.array([0.0, 0.0, 0.0, *shape])
    simplex = start + np.vstack([np.zeros(len(start)), 0.4 * np.eye(len(start))])

    def less(figures: Floats) -> float:
        return -float(gain_of([lobe(figures)])[0])

    found = fmin(
        less,
        start,
        initial_simplex=simplex,
        maxiter=STEPS,
        disp=False,
    )
    return lobe(found)


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


def _places(scenery: Scenery, channels: tuple[str, ...]) -> tuple[Floats, Floats]:
    """Rows and columns of the middles of blocks in px."""
    place = np.indices((scenery.body.height, scenery.body.width), dtype=np.float32) + 0.5
    y, x = (
        blocks_of(np.repeat(one[..., None], 3, axis=-1), scenery.view, channels).mean(axis=0)
        for one in place
    )
    return y, x


def _on_blocks(lobes: Sequence[Lobe], place: tuple[Floats, Floats], block_px: int) -> Floats:
    """Each lobe as the blocks see it, up to a factor, (lobes, blocks).

    The mean of a normal profile over a block of side d is all but normal, with the variance
    sigma^2 + d^2 / 12.
    """
    figures = [(o.y_px, o.x_px, o.sigma_px**2, o.longer, np.radians(o.slant_deg)) for o in lobes]
    y_px, x_px, sigma2, longer, slant = np.array(figures).T[:, :, None]
    y, x = place[0] - y_px, place[1] - x_px
    of_block = block_px**2 / 12
    along = np.square(x * np.cos(slant) + y * np.sin(slant)) / (sigma2 * longer + of_block)
    across = np.square(y * np.cos(slant) - x * np.sin(slant)) / (sigma2 / longer + of_block)
    return np.asarray(np.exp(-0.5 * (along + across)))


def _amplitudes(case: Case) -> Floats:
    """Light of a patch that is as bright as the scene in the mean, in DN, (shots, channels)."""
    base, scenery = case.known.base, case.known.scenery
    found = np.zeros((len(scenery.shots), len(base.channels)))
    for k, shot in enumerate(scenery.shots):
        if not shot.dark:
            one = lamp_dn(base, scenery.light, scenery.view, lamp_of(shot))
            found[k] = exposure_of(shot) * one.mean(axis=1)
    return found
