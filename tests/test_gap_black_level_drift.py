"""The walk of a black level is told by the means of dark frames and of their rows."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from analysis.gap.ready.black_level_drift import (
    STEP_DN,
    Walk,
    along_the_shots,
    response_of,
    walk,
    wandering,
    wanders,
)
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import look
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.row_noise import RowNoise
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.record import record
from tests.short import PROTOCOL, camera, light

FRAMES = 40


def walks(
    number: int, sigma_e: float, length: float, white_e: float, seed: int, count: int = FRAMES
) -> np.ndarray:
    """Series of a first-order process with white noise on top: means of the frames of shots."""
    rng = np.random.default_rng(seed)
    rho = np.exp(-1.0 / length)
    there = sigma_e * rng.standard_normal(number)
    means = []
    for _ in range(count):
        means.append(there + white_e * rng.standard_normal(number))
        there = rho * there + np.sqrt(1 - rho**2) * sigma_e * rng.standard_normal(number)
    return np.transpose(means)


def told_by(means: np.ndarray, lost: int = 0) -> Walk:
    """The walk of series with a constant of their own."""
    steps = np.arange(means.shape[1], dtype=float)
    apart = np.abs(np.subtract.outer(steps, steps))
    constant = np.ones((len(steps), 1))
    return walk(means, apart, constant, longest=4.0 * len(steps), lost=lost)


@pytest.mark.parametrize("length", [3.0, 8.0])
def test_the_walk_is_that_of_an_ornstein_uhlenbeck_process(length: float) -> None:
    """At 4 standard errors for four figures. These are at least those of a walk without noise on
    top: its F steps in each of N series tell the logarithm of s^2 / L to sqrt(2 / N F), and F / 2 L
    figures in each that forget each other that of s^2 to sqrt(4 L / N F)."""
    number = 400
    found = told_by(walks(number, 5.0, length, 2.0, seed=1))
    assert found.sigma_error / found.sigma > 0.5 * np.sqrt(4 * length / (number * FRAMES)) / 2
    assert abs(found.sigma - 5.0) < 4 * found.sigma_error
    assert abs(found.length - length) < 4 * found.length_error


def test_errors_of_a_walk_are_those_that_other_captures_scatter_by() -> None:
    """Of 100 captures of one dark 90 % have the spread in their interval of 90 %: 82 or more at a
    chance of 0.01, and the scatter of 3.3 walks that forget is no normal number."""
    rng = np.random.default_rng(4)
    held = 0
    for _ in range(100):
        rows = walks(24, 3.0, 20.0, 1.0, seed=int(rng.integers(2**31)), count=100)
        found = told_by(rows - rows.mean(axis=0), lost=1)
        held += abs(found.sigma - 3.0) < 1.645 * found.sigma_error
    assert 82 <= held <= 98


def test_white_noise_does_not_wander_and_a_walk_does() -> None:
    """Steps of white noise have twice the variance of its deviations; those of a walk, 1 - rho of
    that. At five standard errors none of 1,000 captures of three darks is called a walk; of walks
    that forget in 8 frames, with as much white noise, nearly all are."""
    still = walks(3000, 0.0, 8.0, 2.0, seed=2)
    assert not any(wanders([still[k : k + 3]]) for k in range(0, 3000, 3))
    moving = walks(300, 4.0, 8.0, 2.0, seed=3)
    told = sum(wanders([moving[k : k + 3]]) for k in range(0, 300, 3))
    assert told > 80


@pytest.mark.whole
def test_a_capture_whose_black_walks_begins_where_moments_put_it() -> None:
    """Two darks of 64 frames, whose black forgets in 20: their shots have other black levels, which
    a calibration without a walk puts into its light. With it G, whose error is a twentieth, is no
    more than of a right model. What chance has of it is not asked: between two shots whose blacks
    are each one draw of the walk, least squares end at a row noise of nothing or of 2 e- (p = 0.6
    or 3e-5), on one machine and another."""
    dark, dim, bright = (dataclasses.replace(shot, frames=64) for shot in PROTOCOL.shot)
    other = dataclasses.replace(dark, label="long dark", exposure_s=0.04)
    protocol = dataclasses.replace(PROTOCOL, shot=(dark, other, dim, bright))
    walking = BlackLevelDrift(row_sigma_e=0.0, frame_sigma_e=12.0, frame_length=20.0)
    for effects in ((walking,), ()):
        made = camera().plus(*effects).with_body(5)
        taken = record(made, protocol, {"lamp": light().rate_e_per_s}, seed=5)
        setting = look(taken, {"lamp": light()})
        assert setting is not None
        told = wandering(setting)
        assert (told is not None) is bool(effects)
        if told is None:
            continue
        # of 128 frames 3 are independent
        assert told.hints["frame_sigma_e"] == pytest.approx(12.0, rel=0.8)
        found = diagnose(taken, stated={"lamp": light()}, suspects=suspects()).report
        assert [e.name for e in found.effects] == ["black_level_drift"]
        assert found.gap.before > 0.5
        assert abs(found.gap.after) < 0.1


def test_what_walks_down_the_rows_is_told_by_their_means() -> None:
    """Two figures at 4 of their own standard errors; what these are worth is asked above."""
    dark, dim, bright = (dataclasses.replace(shot, frames=64) for shot in PROTOCOL.shot)
    protocol = dataclasses.replace(PROTOCOL, shot=(dark, dim, bright))
    walking = BlackLevelDrift(row_sigma_e=9.0, row_length=12.0, frame_sigma_e=0.0)
    made = camera().plus(walking).with_body(7)
    taken = record(made, protocol, {"lamp": light().rate_e_per_s}, seed=7)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    told = wandering(setting)
    assert told is not None
    assert told.instead is not None
    assert told.instead.base is not None
    assert told.instead.base.clamp_e2 == 0.0
    for name in ("row_sigma_e", "row_length"):
        found = told.hints[name]
        assert isinstance(found, float)
        assert abs(found - getattr(walking, name)) < 4 * told.errors[name]
        assert told.errors[name] < 0.3 * found


def test_shots_that_share_a_black_level_tell_a_walk_along_them() -> None:
    """Three shots of 24 frames, a walk that forgets in 20 of them: of 200 captures at least 0.85 of
    the intervals of 90 % hold, as they would at a chance of 0.01, and the typical one is right to
    a tenth."""
    rng = np.random.default_rng(6)
    found = []
    for _ in range(200):
        shots = walks(3, 4.0, 20.0, 0.7, seed=int(rng.integers(2**31)), count=24)
        shots += np.array([[5.0], [7.0], [11.0]])  # a black level, and a dark current
        found.append(along_the_shots(list(shots), [0.01, 0.02, 0.04]))
    sigma, error = np.transpose([(one.sigma, one.sigma_error) for one in found])
    assert np.mean(np.abs(sigma - 4.0) < 1.645 * error) >= 0.85
    assert np.median(sigma) == pytest.approx(4.0, rel=0.1)


def test_more_than_are_held_against_each_other_are_looked_at_in_pieces() -> None:
    """Two shots of 400 frames tell a walk that forgets in 8 by the first 128 of each, in time."""
    shots = list(walks(2, 4.0, 8.0, 0.7, seed=8, count=400))
    found, few = (along_the_shots(one, [0.01, 0.02]) for one in (shots, [s[:128] for s in shots]))
    assert found == few
    assert abs(found.sigma - 4.0) < 4 * found.sigma_error


@pytest.mark.parametrize("black_dn", [5.0, 5.25, 5.5, 0.0])
def test_a_mean_follows_its_black_level_as_rounding_and_clipping_let_it(black_dn: float) -> None:
    """Of noise s far from the ends 1 + 2 cos(2 pi b) exp(-2 pi^2 s^2) and smaller terms, in which
    noise and pattern count alike; at code 0, half of the pixels follow."""
    taken = record(camera().with_body(9), PROTOCOL, {"lamp": light().rate_e_per_s}, seed=9)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    dark = setting.darks(1)[0]
    _, base = by_moments(setting)
    still = dataclasses.replace(
        base,
        black_dn=np.full(3, black_dn),
        read_dn2=np.full(3, 0.06),
        fpn_dn2=np.full(3, 0.03),
        shown_e_per_s=0.0,
        dark_e_per_s=0.0,
        dark_spread2=0.0,
    )
    waves = np.arange(1, 4)
    above = np.cos(2 * np.pi * waves * (black_dn - 0.5)) * np.exp(-2 * (np.pi * waves) ** 2 * 0.09)
    by_half = np.sinc(2 * STEP_DN * waves)  # a slope over two steps
    expected = 1 + 2 * float((above * by_half).sum())
    if black_dn == 0.0:
        expected /= 2
    assert response_of(still, dark) == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("effect", [RowNoise(sigma_e=9.0), SpatialDenoise()])
def test_rows_that_forget_at_once_do_not_walk(effect: Effect) -> None:
    """Noise of rows has none in common with the next one, and what a filter mixes ends
    after two rows of a lattice."""
    made = camera().plus(effect).with_body(8)
    taken = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=8)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    assert wandering(setting) is None


def suspects() -> list[type]:
    return [catalogue()[n] for n in ("black_level_drift", "ambient_light", "nonlinearity")]
