"""The space in which captures are compared: every figure in units of its own standard error.

A figure of noise has the spread that simulated twins of the base camera show. A block of the mean
image has a covariance between shots: noise in time by itself, fixed pattern and light in common.

    C = noise / (samples frames) + FPN / samples 1 1' + PRNU^2 / samples m m' + floor

The floor is what nobody knows of the scene: a part of the light of each lamp by itself, and a part
of its slope, because edges are never where one thinks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.body_share import usual_share
from analysis.gap.camera.base import Base
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_blocks import light_noise
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.families import IMAGE
from analysis.gap.look.observation import Key, Observation

Floats = NDArray[np.float64]

LIGHT_FLOOR = 0.001
"""Of a known light, block by block."""

UNKNOWN_LIGHT = 10.0
"""Of a light read from the frames: what all shots of a lamp have in common tells nothing."""

EDGE_FLOOR_PX = 0.02
"""By how much an edge may be elsewhere."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Common:
    """What groups of blocks have in common, and how it is taken off their coordinates.

    Of coordinates with the covariance 1 + U U^T the symmetric root of the inverse is

        1 - Q (1 - 1 / sqrt(1 + L)) Q^T,    U U^T = Q L Q^T

    Attributes:
        members: places of the coordinates of each group, (groups, m).
        q: (groups, m, k) orthonormal columns.
        widths: sqrt(1 + L), (groups, k).
    """

    members: NDArray[np.intp]
    q: Floats
    widths: Floats

    def off(self, vector: Floats) -> Floats:
        """Coordinates of which it is taken off."""
        left = vector.copy()
        along = np.einsum("gmk,gm->gk", self.q, vector[self.members])
        left[self.members] -= np.einsum("gmk,gk->gm", self.q, along * (1.0 - 1.0 / self.widths))
        return left

    def log_widths(self, size: int) -> Floats:
        """What it adds to the logarithms of widths, even over each group's coordinates, (size,)."""
        added = np.zeros(size)
        added[self.members] += np.log(self.widths).sum(axis=1)[:, None] / self.members.shape[1]
        return added


def common(members: NDArray[np.intp], seen: Floats) -> Common:
    """What groups have in common.

    Args:
        members: places of the coordinates of each group, (groups, m).
        seen: what each thing of unit variance makes of them, (groups, m, k).
    """
    squares, v = np.linalg.eigh(seen.swapaxes(-1, -2) @ seen)
    squares = np.maximum(squares, 0.0)
    length = np.sqrt(np.maximum(squares, 1e-12))
    return Common(members=members, q=(seen @ v) / length[:, None, :], widths=np.sqrt(1.0 + squares))


@dataclass(frozen=True, kw_only=True, eq=False)
class Space:
    """Where figures and blocks are in units of their standard errors.

    Its coordinates are the figures, then the block means of all shots and channels, one after the
    other: keys + shots channels blocks of them.

    Attributes:
        keys: of the figures.
        expected_figures: mean of each figure over the twins, in its own unit, (keys,).
        expected_means: mean over the twins of the block means in DN, (shots, channels, blocks).
        spread: standard error of each figure's difference, real less expected, (keys,).
        whitening: (channels, blocks, shots, shots), inverse Cholesky factors.
        shape: shots, channels, blocks.
        common: what blocks have in common, one after the other.
    """

    keys: tuple[Key, ...]
    expected_figures: Floats
    expected_means: Floats
    spread: Floats
    whitening: Floats
    shape: tuple[int, int, int]
    common: tuple[Common, ...] = ()

    @property
    def families(self) -> NDArray[np.str_]:
        """Family of each coordinate."""
        of_blocks = [IMAGE] * int(np.prod(self.shape))
        return np.array([key.family for key in self.keys] + of_blocks)

    def figures(self, difference: Floats) -> Floats:
        """Differences of figures as coordinates."""
        return difference / self.spread

    def blocks(self, difference: Floats) -> Floats:
        """Differences of block means, (shots, channels, blocks), as coordinates."""
        by_block = difference.transpose(1, 2, 0)[..., None]
        white = (self.whitening @ by_block)[..., 0]
        found = white.transpose(2, 0, 1).ravel()
        for one in self.common:
            found = one.off(found)
        return np.asarray(found)

    @property
    def log_widths(self) -> Floats:
        """Logarithm of the standard error of each coordinate; twice their sum is log det C."""
        of_blocks = -np.log(np.diagonal(self.whitening, axis1=-2, axis2=-1))
        widths = of_blocks.transpose(2, 0, 1).ravel()
        widths = widths + sum(one.log_widths(len(widths)) for one in self.common)
        return np.concatenate([np.log(self.spread), widths])

    def vector(self, figures: Floats, means: Floats) -> Floats:
        """A difference as one vector of coordinates, in standard errors, (coordinates,).

        Args:
            figures: difference of each figure in its own unit, (keys,).
            means: difference of the block means in DN, (shots, channels, blocks).
        """
        return np.concatenate([self.figures(figures), self.blocks(means)])

    def of(self, seen: Observation, groups: slice = slice(None)) -> Floats:
        """A capture's difference from what is expected, in standard errors, (coordinates,).

        Args:
            seen: the capture, with these keys.
            groups: of its frames, over which it is averaged.
        """
        return self.vector(
            seen.figures[groups].mean(axis=0) - self.expected_figures,
            seen.means[groups].mean(axis=0) - self.expected_means,
        )


MODEL_ERROR = 0.05
"""Part of a difference that no model is asked to explain better: where a figure is off by a hundred
standard errors, those errors are not what limits a fit."""


def space_of(
    twins: Observation,
    variances: Floats,
    base: Base,
    scenery: Scenery,
    groups: int,
    floors: bool = True,
    seen: Observation | None = None,
    shares: Floats | None = None,
) -> Space:
    """The space for a capture.

    Args:
        twins: twins of the base camera; each group of it is another body.
        variances: of the figures of one group; see `figure_errors`.
        base: the calibrated camera.
        scenery: light and shots.
        groups: groups of the real capture that are averaged.
        floors: whether nobody knows the light quite; a simulated capture's own is known.
        seen: the capture; what differs much is not asked to be explained to its error.
        shares: parts of the variances that are a body's; the usual ones by default.
    """
    count = twins.groups
    of_body = usual_share(twins.keys) if shares is None else shares
    share = of_body + (1.0 - of_body) / groups + 1.0 / count
    expected = twins.means.mean(axis=0)
    figures = twins.figures.mean(axis=0)
    model = 0.0
    if seen is not None:
        model = np.square(MODEL_ERROR * (seen.figures.mean(axis=0) - figures))
    return Space(
        keys=twins.keys,
        expected_figures=figures,
        expected_means=expected,
        spread=np.sqrt(variances * share + model),
        whitening=_whitening(twins, expected, base, scenery, groups, floors),
        shape=(expected.shape[0], expected.shape[1], expected.shape[2]),
    )


def _whitening(
    twins: Observation,
    expected: Floats,
    base: Base,
    scenery: Scenery,
    groups: int,
    floors: bool,
) -> Floats:
    shots, channels, count = expected.shape
    n, bodies = twins.samples, twins.groups
    signal = np.maximum(expected - base.black_dn[:, None], 0.0).transpose(1, 2, 0)
    in_time = twins.noise.T[:, None, :] / (n * twins.frames)
    both = 1.0 + 1.0 / bodies
    covariance = np.zeros((channels, count, shots, shots))
    fixed = base.fpn_dn2[:, None, None, None] / n * both
    covariance += fixed
    exposures_s = np.array([shot.exposure_s for shot in scenery.shots])
    grown = base.dark_spread2 * np.square(base.gain_dn_per_e)[:, None, None, None] / n * both
    covariance += grown * exposures_s[:, None] * exposures_s
    covariance += (
        base.prnu2[:, None, None, None] / n * both * signal[..., :, None] * signal[..., None, :]
    )
    diagonal = np.arange(shots)
    covariance[..., diagonal, diagonal] += in_time * (1.0 / groups + 1.0 / bodies) + 1e-5
    floor = (LIGHT_FLOOR if scenery.light.known else UNKNOWN_LIGHT) if floors else 0.0
    if not scenery.light.known:
        floor = UNKNOWN_LIGHT
    slope = _slope(signal, twins.grid, twins)
    paths = light_noise(scenery.light, scenery.view, twins.channels)
    for lamp in scenery.light.lamps:
        of_lamp = np.array(
            [not shot.dark and lamp_of(shot) == lamp for shot in scenery.shots], dtype=np.float64
        )
        light = signal * of_lamp
        part = floor**2 + paths[lamp][..., None, None] if lamp in paths else floor**2
        covariance += part * light[..., :, None] * light[..., None, :]
    if floors:
        edge = EDGE_FLOOR_PX * slope
        covariance += edge[..., :, None] * edge[..., None, :]
    return np.linalg.inv(np.linalg.cholesky(covariance))


def _slope(signal: Floats, grid: tuple[int, int], twins: Observation) -> Floats:
    """Slope of the mean image per pixel, from block to block, (channels, blocks, shots)."""
    down, across = grid
    image = signal.reshape(signal.shape[0], down, across, signal.shape[2])
    if min(grid) < 2:
        return np.zeros_like(signal)
    pitch_px = 2.0 * np.sqrt(twins.samples)
    size = np.hypot(*np.gradient(image, axis=(1, 2))) / pitch_px
    return np.asarray(size.reshape(signal.shape))
