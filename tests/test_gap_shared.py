"""What blocks of a shot have in common: read from twins, taken off once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.gap.calibrate.ruler import ruler
from analysis.gap.calibrate.shared import Shared, shared
from analysis.gap.calibrate.space import Space, common
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]

SHOTS, CHANNELS, DOWN, ACROSS = 4, 2, 16, 20
BLOCKS = DOWN * ACROSS
TWINS = 24
OWN_DN2, BLACK_DN = 0.04, 5.0
GAIN_DN_PER_E = np.array([0.5, 1.0])
ROW_DN, OFFSET_E, LIGHT = 0.15, 0.3, 0.01

LIGHT_DN = np.linspace(20.0, 60.0, BLOCKS) * np.array([0.0, 0.0, 1.0, 2.0])[:, None, None]
"""Of two darks and two lit shots; green is as bright as the other colour."""

BASE: Any = SimpleNamespace(black_dn=np.full(CHANNELS, BLACK_DN), gain_dn_per_e=GAIN_DN_PER_E)


def space() -> Space:
    """Blocks with independent noise alone."""
    covariance = np.broadcast_to(OWN_DN2 * np.eye(SHOTS), (CHANNELS, BLOCKS, SHOTS, SHOTS))
    return Space(
        keys=(), expected_figures=np.zeros(0), expected_means=BLACK_DN + LIGHT_DN,
        spread=np.zeros(0), whitening=np.linalg.inv(np.linalg.cholesky(covariance)),
        shape=(SHOTS, CHANNELS, BLOCKS),
    )  # fmt: skip


def observation(off: Floats) -> Observation:
    return Observation(
        keys=(), figures=np.zeros((len(off), 0)), shots=("a", "b", "c", "d"), lit=frozenset("cd"),
        channels=("G", "R"), means=BLACK_DN + LIGHT_DN + off,
        noise=np.full((SHOTS, CHANNELS), 4 * OWN_DN2), grid=(DOWN, ACROSS), samples=1, frames=4,
        counted=12,
    )  # fmt: skip


def differences(
    seed: int, count: int = TWINS, *, row_dn: float = 0.0, offset_e: float = 0.0, light: float = 0.0
) -> Floats:
    """(count, shots, channels, blocks) with so much in common."""
    rng = np.random.default_rng(seed)
    off = np.sqrt(OWN_DN2) * rng.standard_normal((count, SHOTS, CHANNELS, BLOCKS))
    rows = rng.standard_normal((count, SHOTS, CHANNELS, DOWN))
    off += row_dn * np.repeat(rows, ACROSS, axis=-1)
    of_frames = rng.standard_normal((2, count, SHOTS, 1, 1))
    return np.asarray(
        off + offset_e * GAIN_DN_PER_E[:, None] * of_frames[0] + light * LIGHT_DN * of_frames[1]
    )


def read(off: Floats) -> tuple[Shared | None, Floats]:
    signal = np.broadcast_to(LIGHT_DN, (SHOTS, CHANNELS, BLOCKS)).transpose(1, 2, 0)
    known = np.broadcast_to(OWN_DN2 * np.eye(SHOTS), (CHANNELS, BLOCKS, SHOTS, SHOTS))
    return shared(ruler(known, BASE, observation(off), signal), off)


def test_a_symmetric_root_makes_coordinates_independent() -> None:
    """T (1 + U U^T) T = 1 in each group, and the widths are half of log det (1 + U U^T)."""
    rng = np.random.default_rng(1)
    members = rng.permutation(12).reshape(2, 6)
    seen = rng.normal(size=(2, 6, 3))
    seen[0, :, 2] = 0.0
    one = common(members, seen)
    covariance = np.eye(12)
    for places, u in zip(members, seen, strict=True):
        covariance[np.ix_(places, places)] += u @ u.T
    t = np.array([one.off(e) for e in np.eye(12)])
    assert t @ covariance @ t == pytest.approx(np.eye(12), abs=1e-9)
    half = 0.5 * np.linalg.slogdet(covariance)[1]
    assert one.log_widths(12).sum() == pytest.approx(half)


@pytest.mark.parametrize("seed", range(20))
def test_independent_blocks_have_nothing_in_common(seed: int) -> None:
    off = differences(seed)
    found, left = read(off)
    assert found is None
    assert left is off


def test_a_shot_that_is_the_same_in_all_twins_has_nothing_in_common() -> None:
    """Codes that lost their lowest bits are all alike in a dark."""
    off = differences(1)
    off[:, 0] = 0.0
    assert read(off)[0] is None
    off[:, :] = 0.0
    assert read(off)[0] is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_variances_are_those_that_went_in(seed: int) -> None:
    """A variance of n squares is known to sqrt(2 / n): rows to that of 24 x 4 x 16, of two
    channels that stand by themselves, frames to that of 24 x 4 less the mean over shots, light to
    that of 24 x 2 less the same. At 4 standard errors for 12 figures, and a fifth more where the
    offset of a lit frame is less certain than that of a dark one."""
    found, left = read(differences(seed, row_dn=ROW_DN, offset_e=OFFSET_E, light=LIGHT))
    assert found is not None
    rows = np.diagonal(found.rows_dn2, axis1=1, axis2=2).mean(axis=1)
    own = OWN_DN2 / ACROSS
    rows_error = 4 * np.sqrt(2 / (TWINS * SHOTS * DOWN)) * (ROW_DN**2 + own)
    assert rows == pytest.approx(np.full(CHANNELS, ROW_DN**2), abs=rows_error)
    few = TWINS * (SHOTS - 1)
    assert found.offset_e2 == pytest.approx(OFFSET_E**2, rel=4 * np.sqrt(2 / few) * 1.2)
    assert found.light2 == pytest.approx(LIGHT**2, rel=4 * np.sqrt(2 / TWINS) * 1.2)
    each = TWINS * SHOTS * CHANNELS * BLOCKS
    assert left.var() == pytest.approx(OWN_DN2, rel=4 * np.sqrt(2 / each) + 1 / DOWN / ACROSS)


def test_what_is_another_one_in_each_group_is_averaged() -> None:
    """Offsets of rows that each of 8 groups has anew have an eighth of their variance in the mean;
    a frame's that stays has all of it. 8 groups tell a part to about sqrt(2 / (7 x 4)), rows, of
    which there are 32 a shot, better."""
    groups = 8
    found, _ = read(differences(1, row_dn=ROW_DN, offset_e=OFFSET_E))
    assert found is not None
    assert found.light2 == 0
    capture = differences(5, groups, row_dn=ROW_DN)
    capture += OFFSET_E * np.random.default_rng(6).standard_normal((SHOTS, 1, 1))
    mean = found.averaged(capture)
    part = np.trace(mean.rows_dn2, axis1=1, axis2=2) / np.trace(found.rows_dn2, axis1=1, axis2=2)
    rows_error = 4 * np.sqrt(2 / ((groups - 1) * SHOTS * CHANNELS * DOWN))
    assert part == pytest.approx(1 / groups, abs=rows_error)
    assert mean.offset_e2 == pytest.approx(found.offset_e2, rel=0.1)
    anew = found.averaged(differences(7, groups, row_dn=ROW_DN, offset_e=OFFSET_E))
    frames_error = 4 * np.sqrt(2 / ((groups - 1) * SHOTS))
    assert anew.offset_e2 / found.offset_e2 == pytest.approx(1 / groups, abs=frames_error)


def test_an_offset_of_a_frame_counts_once() -> None:
    """An offset of variance v over n blocks of width s adds log(1 + v (1 + 1 / t) n / s^2) to
    log det C, once for each shot, where each block by itself would add log(1 + v / s^2) n times.
    A capture whose frames are off by as much has chi-squared as if they were not: but for 1 a
    shot."""
    found, _ = read(differences(1, offset_e=OFFSET_E))
    assert found is not None
    wide = found.taken_off(space(), TWINS)
    v = OFFSET_E**2
    per_dn2 = BLOCKS * np.square(GAIN_DN_PER_E).sum() / OWN_DN2
    found_v = found.offset_e2 * (1 + 1 / TWINS)
    added = SHOTS * np.log(1 + found_v * per_dn2)
    assert 2 * (wide.log_widths.sum() - space().log_widths.sum()) == pytest.approx(added)
    one = differences(9, 1, offset_e=OFFSET_E)[0]
    plain = np.square(differences(9, 1)[0]).sum() / OWN_DN2
    chi2 = np.square(wide.blocks(one)).sum()
    bound = SHOTS * (1 + 4 * np.sqrt(2 / SHOTS)) * v / found_v
    assert abs(chi2 - plain) < 2 * bound
    assert np.square(space().blocks(one)).sum() - plain > 20 * bound
