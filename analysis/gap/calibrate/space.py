"""The space in which captures are compared: every figure in units of its own standard error.

A figure of noise has the spread that simulated twins of the base camera show. A block of the mean
image has a covariance between shots: noise in time by itself, fixed pattern and light in common.

    C = noise / (samples frames) + FPN / samples 1 1' + PRNU^2 / samples m m' + floor

The floor is what nobody knows of the scene: a part of the light of each lamp by itself, and a part
of its slope, because edges are never where one thinks.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.calibrate.body_share import usual_share
from analysis.gap.camera.base import Base
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_blocks import light_noise
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.families import EVERY_SHOT, IMAGE, INTERPOLATION, NEIGHBOURS
from analysis.gap.look.kinds import kinds
from analysis.gap.look.observation import Key, Observation

Floats = NDArray[np.float64]

LIGHT_FLOOR = 0.001
"""Of a known light, block by block."""

UNKNOWN_LIGHT = 10.0
"""Of a light read from the frames: what all shots of a lamp have in common tells nothing."""

EDGE_FLOOR_PX = 0.02
"""By how much an edge may be elsewhere."""

PRIOR_FREEDOM = 8.0
"""Degrees of freedom that a variance borrows from the same statistic in other places."""

LEAST_SPREAD = 1e-6
"""Of a figure that never moved in any twin."""

ROOTS_OF_SHARES = frozenset(
    {"loud pixels", "hot samples", "very hot samples", "at zero", "at the top"}
)
"""Figures that are roots of a share of samples: a count of n has a root with the error 1/2."""


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

    Attributes:
        keys: of the figures.
        expected_figures: mean over the twins.
        expected_means: the same of the block means, (shots, channels, blocks).
        spread: standard error of each figure's difference, real less expected.
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
        """A difference as one vector of coordinates."""
        return np.concatenate([self.figures(figures), self.blocks(means)])

    def of(self, seen: Observation, groups: slice = slice(None)) -> Floats:
        """A capture's difference from what is expected."""
        return self.vector(
            seen.figures[groups].mean(axis=0) - self.expected_figures,
            seen.means[groups].mean(axis=0) - self.expected_means,
        )


ROOT_OF_A_SHARE_OF_BLOCKS = "residual outliers"

MODEL_ERROR = 0.05
"""Part of a difference that no model is asked to explain better: where a figure is off by a hundred
standard errors, those errors are not what limits a fit."""


OF_THE_PICTURE = ("codes", "texture", "grid of 8", "off bilinear", "variance, part")
"""Beginnings of the names of families and statistics that depend on the picture to its last detail:
of lit shots whose light was read from the frames they tell nothing."""

OF_NOISE = frozenset(
    {"rows", "columns", "frames", NEIGHBOURS, "time", "tails", "spectrum", "pattern lines",
     "pattern shape", "dark surface", INTERPOLATION}
)  # fmt: skip
"""Families that tell how noise is shared out among pixels, places and frames, not how much there
is."""

FEW_CHANGES = 100.0
"""Variance in time of all samples of a group of frames together, in DN^2, below which so few of
them change their code that chance shares them out: one pixel with another code in one frame of a
dark makes every such figure, and in most twins there is none."""

NOTHING = 1e4
"""Standard errors become so many times larger where a figure tells nothing."""


def figure_variances(twins: Observation, known: bool = True) -> Floats:
    """Variance of each figure of one group between twins, drawn to that of its like elsewhere.

    Args:
        twins: of one base; each group is another body.
        known: whether the light is known.
    """
    keys, figures = twins.keys, twins.figures
    freedom = len(figures) - 1
    least = np.full(len(keys), LEAST_SPREAD**2)
    blocks = twins.means.shape[-1]
    least[[key.statistic in ROOTS_OF_SHARES for key in keys]] = 0.25 / (twins.samples * blocks)
    least[[key.statistic == ROOT_OF_A_SHARE_OF_BLOCKS for key in keys]] = 0.25 / blocks
    own = np.maximum(figures.var(axis=0, ddof=1), least)
    pooled = own.copy()
    for places in kinds(keys, twins.lit):
        pooled[places] = np.exp(np.mean(np.log(own[places])))
    variances = (freedom * own + PRIOR_FREEDOM * pooled) / (freedom + PRIOR_FREEDOM)
    silent = _of_few_changes(twins)
    if not known:
        silent |= np.array([
            key.shot in twins.lit
            and (key.family.startswith(OF_THE_PICTURE) or key.statistic.startswith(OF_THE_PICTURE))
            for key in keys
        ])  # fmt: skip
    variances[silent] *= NOTHING**2
    return np.asarray(variances)


def _of_few_changes(twins: Observation) -> NDArray[np.bool_]:
    """Which figures tell how noise is shared out where there is next to none, (figures,)."""
    in_all = twins.noise * twins.samples * twins.means.shape[-1] * twins.frames
    few = dict(zip(twins.shots, in_all < FEW_CHANGES, strict=True))
    places = {channel: place for place, channel in enumerate(twins.channels)}

    def tells_nothing(key: Key) -> bool:
        told = key.family in OF_NOISE and key.statistic not in ROOTS_OF_SHARES
        if not told or key.shot not in few:
            return False
        place = places.get(key.lattice[0])  # None: of all channels together
        return bool(few[key.shot].all() if place is None else few[key.shot][place])

    return np.array([tells_nothing(key) for key in twins.keys])


CHANGING_DN2 = 1e-3
"""Variance in time from which some pixels of every frame have another code in the next one: one in
a thousand by a step."""

BEYOND_DOUBT = 16.0
"""Standard errors that a frame counts which repeats the one before, where every frame has noise.
Spreads are read from a few twins, so that 8 of them count as 5, which are lost among a hundred
figures of time; these are not."""


def never_moved(twins: Observation, seen: Observation) -> Floats:
    """Standard errors of figures that are the same in all twins, (figures,); 0 for the others.

    Where a code changes once in a hundred frames a figure may be 0 in every twin and not in the
    capture, and nobody knows how far it goes. Groups of frames are alike where nothing is wrong, so
    that k of the n + g that move are all among the g of the capture with a chance of

        C(g, k) / C(n + g, k)

    and the difference counts as many standard errors as a normal one of that chance. Frames with
    noise in time never repeat each other by chance, nor rows of them: there k repeats are
    BEYOND_DOUBT sqrt(k) standard errors from none.

    Args:
        twins: groups of the model.
        seen: groups of the capture, with the same keys.
    """
    still = np.ptp(twins.figures, axis=0) == 0
    moved = np.count_nonzero(seen.figures != twins.figures[0], axis=0)
    n, g = twins.groups, seen.groups
    chances = np.array([comb(g, k) / comb(n + g, k) for k in range(g + 1)])
    counts = stats.norm.isf(chances / 2)[moved]
    off = np.abs(seen.figures.mean(axis=0) - twins.figures[0])
    errors = np.where(still & (moved > 0), off / np.maximum(counts, 1e-9), 0.0)
    if twins.noise.max(axis=1).min() > CHANGING_DN2:
        repeated = np.array([key.shot == EVERY_SHOT for key in twins.keys])
        of_repeats = np.sqrt(np.maximum(off * seen.counted, 1.0)) / (BEYOND_DOUBT * seen.counted)
        errors = np.where(repeated & still, of_repeats, errors)
    return np.asarray(errors)


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
        variances: of the figures of one group; see `figure_variances`.
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
