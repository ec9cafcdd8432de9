"""Steps of the calibration by themselves, each against what it must do in closed form."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.bias.rounding import rounded
from analysis.gap.calibrate.agreement import agreed
from analysis.gap.calibrate.calibration import Calibration
from analysis.gap.calibrate.darks import (
    NODES,
    WEIGHTS,
    Darks,
    behind_rounding,
    black_by_light,
)
from analysis.gap.calibrate.space import Space
from analysis.gap.camera.base import Base, channels_alike
from analysis.gap.look.observation import Key, Observation
from analysis.gap.measure.distance import Yardstick
from analysis.gap.measure.measured import errors_of
from sensor.effects.white_balance import WhiteBalance
from sensor.protocol import Shot

Floats = NDArray[np.float64]

BLACK_DN, SHOWN_DN_PER_S = 4.3, 30.0
READ_DN2, DARK_DN2_PER_S = 0.35, 4.0
FPN_DN = 0.2


def dark(exposure_s: float) -> tuple[float, float, float]:
    """Mean, variance in time and pattern of darks in whole DN, by exact sums."""
    sigma = np.sqrt(READ_DN2 + DARK_DN2_PER_S * exposure_s)
    pixel = rounded(BLACK_DN + SHOWN_DN_PER_S * exposure_s + FPN_DN * NODES, sigma, 255)
    mean = float(WEIGHTS @ pixel.mean_dn)
    return (
        mean,
        float(WEIGHTS @ np.square(pixel.sd_dn)),
        float(WEIGHTS @ np.square(pixel.mean_dn - mean)),
    )


def test_darks_at_two_exposures_give_their_lines() -> None:
    """What rounding left of a mean and a variance that grow with the exposure gives both back."""
    exposures = np.array([0.008, 0.033])
    seen = np.array([[dark(t)] * 3 for t in exposures])
    found = Darks.of(exposures, seen[..., 0], seen[..., 1], seen[..., 2], 255)
    assert found.black_dn == pytest.approx(BLACK_DN, abs=0.01)
    assert found.mean_dn_per_s == pytest.approx(SHOWN_DN_PER_S, rel=0.02)
    assert found.read_dn2 == pytest.approx(READ_DN2, rel=0.02)
    assert found.variance_dn2_per_s == pytest.approx(DARK_DN2_PER_S, rel=0.1)
    assert found.mean_dn(0.02) == pytest.approx(BLACK_DN + SHOWN_DN_PER_S * 0.02, abs=0.01)


def test_darks_at_one_exposure_have_no_slope() -> None:
    seen = np.array([[dark(0.008)] * 3])
    found = Darks.of(np.array([0.008]), seen[..., 0], seen[..., 1], seen[..., 2], 255)
    assert not found.mean_dn_per_s.any()
    assert not found.variance_dn2_per_s.any()


QUIET_DN, QUIET_FPN_DN, NEAR_A_STEP_DN = 0.19, 0.1, 5.3


def test_two_codes_tell_a_phase_and_light_tells_the_noise() -> None:
    """Where a dark shows two codes, its mean is Phi((black - 5.5) / noise): another black level of
    another noise gives the same. A mean that is off by 0.002 DN moves read noise by a tenth or
    more, and by a fiftieth where the black level is told."""
    pixel = rounded(NEAR_A_STEP_DN + QUIET_FPN_DN * NODES, QUIET_DN, 255)
    mean = float(WEIGHTS @ pixel.mean_dn)
    in_time = float(WEIGHTS @ np.square(pixel.sd_dn))
    pattern = float(WEIGHTS @ np.square(pixel.mean_dn - mean))
    off = 0.002
    free = behind_rounding(mean + off, in_time, pattern, 255)
    told = behind_rounding(mean + off, in_time, pattern, 255, NEAR_A_STEP_DN)
    assert abs(np.sqrt(free[1]) / QUIET_DN - 1) > 0.1
    assert np.sqrt(told[1]) == pytest.approx(QUIET_DN, rel=0.02)
    assert np.sqrt(told[2]) == pytest.approx(QUIET_FPN_DN, rel=0.05)


def test_lit_shots_point_to_the_black_level() -> None:
    """Means are black + slope x exposure x level for each lamp; a block that is saturated in one of
    the shots says nothing, and a lamp with one level draws no line."""
    shots = (
        Shot(label="dark", exposure_s=0.01, frames=8),
        Shot(label="dim", light=("a",), level=(0.25,), exposure_s=0.02, frames=8),
        Shot(label="bright", light=("a",), level=(1.0,), exposure_s=0.02, frames=8),
        Shot(label="other", light=("b",), level=(1.0,), exposure_s=0.02, frames=8),
    )
    slope = np.array([3e3, 5e3, 4e4])
    black = np.array([4.4, 5.1])
    amount = np.array([0.0, 0.005, 0.02, 0.02])
    means = np.minimum(black[None, :, None] + slope * amount[:, None, None], 255.0)
    means[3] = 90.0
    seen: Any = SimpleNamespace(means=means[None])
    scenery: Any = SimpleNamespace(shots=shots, view=SimpleNamespace(top_dn=255))
    assert black_by_light(seen, scenery) == pytest.approx(black, abs=1e-9)
    one_level: Any = SimpleNamespace(shots=(shots[0], *shots[2:]), view=scenery.view)
    assert black_by_light(SimpleNamespace(means=means[None, [0, 2, 3]]), one_level) is None


KINDS, OF_A_KIND, SIGNAL = 40, 20, 12.0


def observation(figures: np.ndarray) -> Observation:
    """Figures of many kinds and an image of nothing."""
    keys = tuple(
        Key(shot=f"s{k}", lattice="G", family="f", statistic=f"kind {kind}")
        for kind in range(KINDS)
        for k in range(OF_A_KIND)
    )
    return Observation(
        keys=keys,
        figures=figures[None],
        shots=("s0",),
        lit=frozenset(),
        channels=("G",),
        means=np.zeros((1, 1, 1, 1)),
        noise=np.ones((1, 1)),
        grid=(1, 1),
        samples=1,
        frames=2,
        counted=2,
    )


def test_a_direction_is_as_long_as_what_moves() -> None:
    """One kind of figure moves by 12 standard errors, 39 kinds do not. Amounts measured along a
    direction shrink by true length^2 over its length^2: 0.79 for the plain mean of two sets of
    random numbers, and within 5 % of 1 for what they agree on."""
    rng = np.random.default_rng(5)
    truth = np.zeros(KINDS * OF_A_KIND)
    truth[:OF_A_KIND] = SIGNAL * np.sqrt(0.5)
    before = [observation(np.zeros_like(truth))] * 2
    after = [observation(truth + rng.standard_normal(len(truth))) for _ in range(2)]
    drawn, _ = agreed(before, after)
    plain = np.mean([o.figures[0] for o in after], axis=0)
    assert truth @ truth / (plain @ plain) < 0.85
    assert truth @ drawn / (drawn @ drawn) == pytest.approx(1.0, abs=0.05)


BLOCKS = 400


def image(picture: np.ndarray, change: np.ndarray) -> tuple[Observation, Observation]:
    """Before and after a change of block means, (shots, channels, blocks)."""
    shots, channels = picture.shape[:2]
    before = dataclasses.replace(
        observation(np.zeros(KINDS * OF_A_KIND)),
        shots=tuple(f"s{k}" for k in range(shots)),
        channels=("R", "G", "B")[:channels],
        means=picture[None],
    )
    return before, dataclasses.replace(before, means=(picture + change)[None])


def changed(
    truth: np.ndarray, noise: float, of_bodies: float = 0.0, alike: bool = False
) -> np.ndarray:
    """What two sets of random numbers agree on of a change of pictures."""
    rng, bodies = np.random.default_rng(7), np.random.default_rng(8)
    pictures = rng.uniform(20.0, 200.0, truth.shape)
    picture = np.broadcast_to(pictures[0, 0], truth.shape) if alike else pictures
    pairs = [
        image(picture, truth + rng.normal(0, noise, truth.shape)
              + bodies.normal(0, of_bodies, truth.shape[1:])) for _ in range(2)
    ]  # fmt: skip
    return agreed([before for before, _ in pairs], [after for _, after in pairs])[1]


def test_a_change_of_all_blocks_alike_is_read_without_the_noise_of_each() -> None:
    """A black level moves 300 blocks by 0.3, each with noise of 0.3: the plain mean of two sets has
    half as much chi-squared again, 1 + 1 / 2, and what is agreed on has one part in a hundred."""
    truth = np.full((2, 3, BLOCKS), 0.3)
    drawn = changed(truth, noise=0.3)
    assert (drawn * drawn).sum() / (truth * truth).sum() == pytest.approx(1.0, abs=0.03)
    assert np.square(drawn - truth).sum() < 0.01 * np.square(truth).sum()


def test_an_amount_along_an_image_is_right_whatever_its_noise() -> None:
    """Another image in every shot, as faint as its noise. Of the plain mean, amounts are too small
    by 1 + 1 / 2; drawn to zero by what the two sets do not agree on, they are right."""
    truth = np.random.default_rng(3).normal(0, 0.3, (2, 3, BLOCKS))
    drawn = changed(truth, noise=0.3)
    assert (truth * drawn).sum() / (drawn * drawn).sum() == pytest.approx(1.0, abs=0.05)


def test_a_shape_that_all_shots_share_has_the_noise_of_one() -> None:
    """Vignetting takes the same part of every shot and colour. A matrix of one shape, R rows of B
    blocks, is known to a square of (R + B) times that of a block; row by row it is R times B, six
    times as much."""
    rng = np.random.default_rng(9)
    rows, noise = 2 * 3, 0.3
    truth = rng.uniform(1, 3, (2, 3, 1)) * rng.normal(0, 0.5, BLOCKS)
    missed = np.square(changed(truth, noise, alike=True) - truth).sum()
    of_a_block = noise**2 / 2
    assert missed == pytest.approx((rows + BLOCKS) * of_a_block, rel=0.25)
    assert missed < 0.25 * rows * BLOCKS * of_a_block


def test_a_prior_that_keeps_steps_short_is_no_knowledge() -> None:
    """Of a direction that is L errors long with a prior of 1, the variance is 1 / (L^2 + 1), and
    1 / L^2 without the prior; one of which frames tell less than the prior has no error. What twins
    scatter is larger by 1 + 1 / L^2, as the prior has drawn it to zero by that."""
    lengths = np.array([4.0, 0.5, 2.0])
    solve = np.diag(1.0 / np.sqrt(lengths**2 + 1.0))
    turned = Calibration(space=cast(Space, None), q=np.eye(3), solve=solve, priors=np.ones(3))
    scatter = np.array([0.1, 0.1, 0.8])
    spread: Any = SimpleNamespace(errors=lambda groups: scatter)
    found = errors_of(Yardstick(turned=turned, spread=spread), groups=3)
    assert found == pytest.approx([1 / 4, np.inf, 0.8 * (1 + 1 / 4)])


def test_a_pattern_of_each_body_is_no_template() -> None:
    """Other pixels in every body, the same in all of its shots: of the square of the mean of two,
    1/2, no more than a fiftieth is left."""
    assert np.square(changed(np.zeros((2, 3, BLOCKS)), 0.1, of_bodies=1.0)).mean() < 0.01


def test_shots_in_which_nothing_moves_stay_still_beside_one_in_which_all_does() -> None:
    truth = np.zeros((2, 3, BLOCKS))
    truth[1] = np.random.default_rng(4).normal(0, 3.0, (3, BLOCKS))
    drawn = changed(truth, noise=0.3)
    assert np.square(drawn[0]).sum() < 0.1 * 0.3**2 / 2 * 3 * BLOCKS
    assert np.square(drawn[1] - truth[1]).mean() == pytest.approx(0.3**2 / 2, rel=0.2)


def plain() -> Base:
    """A camera whose channels differ in all that they can."""
    return Base(
        channels=("R", "G", "B"), gain_dn_per_e=np.array([0.022, 0.02, 0.027]),
        read_dn2=np.array([0.4, 0.2, 0.3]), fpn_dn2=np.array([0.02, 0.03, 0.04]),
        prnu2=np.array([1e-4, 2e-4, 3e-4]), black_dn=np.array([6.4, 6.8, 6.5]), dark_e_per_s=300.0,
        shown_e_per_s=0.0, dark_spread2=0.0, dark_uneven=0.0, clamp_e2=0.0, arithmetic=0,
        white_balance=None, blur_px2=0.0,
        level={"lamp": np.array([0.9, 1.0, 1.1])},
    )  # fmt: skip


@pytest.mark.parametrize("about_black", [0.0, 1.0])
def test_gains_behind_the_converter_leave_frames_as_they_were(about_black: float) -> None:
    """DN' = o + k (DN - o) gives gain, noise and black level back, once and on top of others."""
    base = plain()
    first = WhiteBalance(red_gain=1.1, blue_gain=1.2, about_black=about_black)
    more = WhiteBalance(red_gain=1.05, blue_gain=0.9)
    of_whole_codes = base.multiplied(first).multiplied(more)
    gains = of_whole_codes.white_balance
    assert gains is not None
    assert gains.about_black == about_black
    k = np.array([gains.red_gain, 1.0, gains.blue_gain])
    origin = base.black_dn.mean() * about_black
    assert k * of_whole_codes.gain_dn_per_e == pytest.approx(base.gain_dn_per_e)
    assert k**2 * of_whole_codes.read_dn2 == pytest.approx(base.read_dn2)
    assert k**2 * of_whole_codes.fpn_dn2 == pytest.approx(base.fpn_dn2)
    # channels have a black level of their own, of which a camera has the mean as its origin
    black_dn = origin + k * (of_whole_codes.black_dn - origin)
    assert black_dn == pytest.approx(base.black_dn, abs=0.03)


def test_channels_that_are_alike_are_as_bright_as_before() -> None:
    """Green's figures in all channels, and each lamp's level so that gain times level, which a
    picture shows, stays as it was to single precision."""
    base = plain()
    even = channels_alike(base)
    for figure, green in (("gain_dn_per_e", 0.02), ("read_dn2", 0.2), ("fpn_dn2", 0.03),
                          ("prnu2", 2e-4), ("black_dn", 6.8)):  # fmt: skip
        assert np.all(getattr(even, figure) == green), figure
    bright, before = (one.gain_dn_per_e * one.level["lamp"] for one in (even, base))
    assert bright == pytest.approx(before, rel=1e-6)


def test_dark_current_that_differs_is_read_behind_rounding() -> None:
    """Offsets and noise of a fifth of a DN, a black level between two codes, and dark current that
    takes the long dark upon one: the pattern doubles in variance, that of the codes shrinks. That
    of 80,000 photosites is known to a hundredth behind rounding, and a tenth is allowed."""
    rng = np.random.default_rng(3)
    exposure_s, sigma, grown = np.array([0.01, 0.04]), 0.2, 0.04
    current = np.sqrt(grown / (exposure_s[1] ** 2 - exposure_s[0] ** 2)) * rng.normal(size=80_000)
    offsets = 6.5 + sigma * rng.normal(size=80_000)
    moments = []
    for t in exposure_s:
        level = offsets + current * t + 0.5 * (t == exposure_s[1])
        codes = np.rint(level + sigma * rng.normal(size=(16, 80_000)))
        halves = codes[::2].mean(axis=0), codes[1::2].mean(axis=0)
        moments.append((codes.mean(), codes.var(axis=0, ddof=1).mean(), np.cov(*halves)[0, 1]))
    mean, in_time, pattern = np.array(moments).T[..., None]
    assert pattern[1, 0] < pattern[0, 0]
    found = Darks.of(exposure_s, mean, in_time, pattern, 255)
    lever = exposure_s[1] ** 2 - exposure_s[0] ** 2
    assert found.pattern_dn2_per_s2[0] * lever == pytest.approx(grown, rel=0.1)
