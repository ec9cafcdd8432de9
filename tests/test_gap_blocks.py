"""How uncertain blocks and figures of twins are."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.calibrate.figure_errors import (
    FEW_CHANGES,
    NOTHING,
    figure_variances,
    never_moved,
)
from analysis.gap.calibrate.space import Space
from analysis.gap.calibrate.wide import beyond, widened
from analysis.gap.look.families import EVERY_SHOT
from analysis.gap.look.observation import Key, Observation

Floats = NDArray[np.float64]

BLOCKS, SHOTS_OF_IT, OWN_DN2, OWN_GROUPS, BODIES = 400, 3, 0.04, 4, 8
OWN_BLACK_DN = 5.0
DARK_BASE: Any = SimpleNamespace(black_dn=np.array([OWN_BLACK_DN]), gain_dn_per_e=np.ones(1))


def space_of_blocks(groups: int, means_dn: Floats) -> Space:
    """Blocks of one channel: noise in time of so many groups of frames, and of the twins' mean."""
    variance = OWN_DN2 * (1 / groups + 1 / BODIES)
    covariance = np.broadcast_to(variance * np.eye(SHOTS_OF_IT), (1, BLOCKS, 3, 3))
    return Space(
        keys=(), expected_figures=np.zeros(0), expected_means=means_dn, spread=np.zeros(0),
        whitening=np.linalg.inv(np.linalg.cholesky(covariance)),
        shape=(SHOTS_OF_IT, 1, BLOCKS),
    )  # fmt: skip


def twins_of_blocks(means_dn: Floats, lit: str = "") -> Observation:
    """Twins of which nothing but the blocks of three shots is known, (bodies, 3, 1, blocks)."""
    return Observation(
        keys=(), figures=np.zeros((BODIES, 0)), shots=("a", "b", "c"), lit=frozenset(lit),
        channels=("Y",), means=means_dn, noise=np.ones((3, 1)), grid=(20, 20), samples=1, frames=4,
        counted=12,
    )  # fmt: skip


@pytest.mark.parametrize(("added_dn2", "part"), [(0.0, 0.0), (0.5, 0.0), (0.0, 0.02)])
def test_blocks_are_as_uncertain_as_twins_show_them(added_dn2: float, part: float) -> None:
    """Of three shots of t twins the first is dark and the last has three times the light of the
    second, of 20 to 100 DN from block to block. A pattern of variance a that all shots have adds
    a (1 + 1 / t) to every variance and covariance of a block; one that takes a part p of the light
    in the mean, p^2 m_s m_t (1 + 1 / t), as much as the block is bright and nothing in the dark.
    Groups of a capture average the noise, not the pattern. A variance of 8 twins is known to
    sqrt(2 / 2800), two terms of it to twice that: at 4.5 standard errors. One width for all shots
    or all blocks would fail."""
    rng = np.random.default_rng(6)
    light_dn = np.linspace(20.0, 100.0, BLOCKS) * np.array([0.0, 1.0, 3.0])[:, None, None]
    means = OWN_BLACK_DN + light_dn
    means = means + np.sqrt(OWN_DN2) * rng.standard_normal((BODIES, SHOTS_OF_IT, 1, BLOCKS))
    pattern = rng.standard_normal((BODIES, 1, 1, BLOCKS))
    means += (np.sqrt(added_dn2) + part * light_dn) * pattern
    bodies = twins_of_blocks(means, lit="bc")
    beside = beyond(space_of_blocks(1, means.mean(axis=0)), DARK_BASE, bodies)
    assert beside.shared is None
    of_all = widened(space_of_blocks(OWN_GROUPS, means.mean(axis=0)), beside, bodies)
    both = 1 + 1 / BODIES
    noise = OWN_DN2 * (1 / OWN_GROUPS + 1 / BODIES)
    root = np.linalg.inv(of_all.whitening[0])
    found = (root @ root.transpose(0, 2, 1))[[0, -1]]
    for block, place in zip(found, (0, -1), strict=True):
        light = light_dn[:, 0, place]
        more = (added_dn2 + part**2 * light[:, None] * light) * both
        expected = noise * np.eye(SHOTS_OF_IT) + more
        own = np.diagonal(more) + OWN_DN2 * both
        error = 4.5 * 2 * np.sqrt(2 / (BLOCKS * (BODIES - 1))) * np.sqrt(own[:, None] * own)
        assert np.all(np.abs(block - expected) < error), (block, expected)


def test_spots_of_twins_do_not_tell_where_those_of_another_body_are() -> None:
    """In a dark all blocks are alike, and a spot of a twin is as likely in each. A capture whose
    spots lie elsewhere is as near as a twin where blocks with a spot have the width of those
    without. By the brightness of the mean over twins they differ hundreds of times."""
    rng = np.random.default_rng(8)
    exposures = np.array([1.0, 4.0, 4.0])[:, None, None]
    dark_dn = OWN_BLACK_DN + 0.1 * exposures
    spots = rng.exponential(5.0, (BODIES, 1, 1, BLOCKS)) * (
        rng.random((BODIES, 1, 1, BLOCKS)) < 0.02
    )
    means = dark_dn + exposures * spots
    means = means + np.sqrt(OWN_DN2) * rng.standard_normal(means.shape)
    twins = twins_of_blocks(means)
    beside = beyond(space_of_blocks(1, means.mean(axis=0)), DARK_BASE, twins)
    assert beside.shared is None
    spotted = spots.any(axis=(0, 1, 2))
    width = np.diagonal(beside.own[0], axis1=-2, axis2=-1)
    assert width[spotted].mean(axis=0) == pytest.approx(width[~spotted].mean(axis=0), rel=1e-9)


def twins_that_stay(noise_dn2: float) -> Observation:
    """Figures that are 0 in all of 16 twins of 2 shots; the last is how many frames repeat."""
    names = {"a code": "a", "another": "a", "repeated frames": EVERY_SHOT}
    return Observation(
        keys=tuple(
            Key(shot=shot, lattice="Y", family="time", statistic=name)
            for name, shot in names.items()
        ),
        figures=np.zeros((16, 3)), shots=("a", "b"), lit=frozenset(), channels=("Y",),
        means=np.zeros((16, 2, 1, 1)), noise=np.full((2, 1), noise_dn2), grid=(1, 1), samples=1,
        frames=4, counted=8,
    )  # fmt: skip


@pytest.mark.parametrize(("moved", "chance"), [(1, 3 / 19), (2, 3 / 171), (3, 1 / 969)])
def test_a_figure_that_no_twin_moved_is_as_rare_as_groups_say(moved: int, chance: float) -> None:
    """Of 16 twins and 3 groups of a capture those that move are by chance all in the capture as
    often as 3 of 19 are drawn: 3/19, 3/19 2/18, 3/19 2/18 1/17. How far they move counts nothing; a
    figure that moves in twins has an error of its own, one that stays needs none."""
    one = twins_that_stay(noise_dn2=1.0)
    one.figures[3, 1] = 0.1
    figures = np.zeros((3, 3))
    figures[:moved, :2] = 0.7
    seen = dataclasses.replace(one, figures=figures)
    errors = never_moved(one, seen)
    z = figures.mean(axis=0)[0] / errors[0]
    assert 2 * stats.norm.sf(z) == pytest.approx(chance)
    assert errors[1] == 0.0


def test_frames_with_noise_never_repeat_by_chance() -> None:
    """3 groups of 4 frames in 2 shots: one of 24 frames is beyond doubt, four are twice as far, as
    counts go, and so they are for one group of them, which is told what all of them repeat. Darks
    without noise are as rare as groups say."""
    by_chance = stats.norm.isf(0.5 / 969)
    cases = ((0.3, 1, 16.0), (0.3, 4, 32.0), (0.0, 1, by_chance), (0.0, 4, by_chance))
    for noise_dn2, repeats, z in cases:
        figures = np.zeros((3, 3))
        figures[:, 2] = repeats / 24
        one = twins_that_stay(noise_dn2)
        seen = dataclasses.replace(one, figures=figures, counted=24)
        assert repeats / 24 / never_moved(one, seen)[2] == pytest.approx(z)
        part = dataclasses.replace(seen, figures=figures[:1])
        if noise_dn2:
            assert repeats / 24 / never_moved(one, part)[2] == pytest.approx(z)


def test_few_changes_of_codes_tell_nothing_of_where_they_are() -> None:
    """One pixel of a dark that has another code in one frame makes a kurtosis, and is in one group
    of frames out of many. How much noise there is they still tell."""
    kinds = {"tails": "kurtosis", "transfer": "variance", "pattern shape": "hot samples"}
    keys = tuple(
        Key(shot=shot, lattice="Y", family=family, statistic=statistic)
        for shot in ("quiet", "loud")
        for family, statistic in kinds.items()
    )
    samples, frames = 50, 8
    in_all = np.array([[0.9 * FEW_CHANGES], [1.1 * FEW_CHANGES]])
    twins = Observation(
        keys=keys, figures=np.random.default_rng(2).normal(size=(16, 1)) * np.ones(len(keys)),
        shots=("quiet", "loud"), lit=frozenset(), channels=("Y",), means=np.zeros((16, 2, 1, 1)),
        noise=in_all / (samples * frames), grid=(1, 1), samples=samples, frames=frames, counted=16,
    )  # fmt: skip
    errors = np.sqrt(figure_variances(twins))
    np.testing.assert_allclose(errors / errors[-1], [NOTHING, 1, 1, 1, 1, 1])
