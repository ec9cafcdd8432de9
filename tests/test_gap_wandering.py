"""The walk of a black level is told by the means of dark frames and of their rows."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from analysis.gap.ready.setting import look
from analysis.gap.ready.wandering import walk, wandering, wanders
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
) -> list[np.ndarray]:
    """Series of a first-order process with white noise on top: means of the frames of a shot."""
    rng = np.random.default_rng(seed)
    rho = np.exp(-1.0 / length)
    there = sigma_e * rng.standard_normal(number)
    means = []
    for _ in range(count):
        means.append(there + white_e * rng.standard_normal(number))
        there = rho * there + np.sqrt(1 - rho**2) * sigma_e * rng.standard_normal(number)
    return list(np.transpose(means))


@pytest.mark.parametrize("length", [3.0, 8.0])
def test_the_walk_is_that_of_an_ornstein_uhlenbeck_process(length: float) -> None:
    """A shot of F frames is worth F / 2 L independent ones, and so the variance of N shots has the
    relative error sqrt(4 L / N F), a standard deviation half of it, and the length twice of that:
    at 4 standard errors for four figures."""
    number = 400
    sigma, found = walk(walks(number, 5.0, length, 2.0, seed=1))
    error = np.sqrt(4 * length / (number * FRAMES))
    assert sigma == pytest.approx(5.0, rel=4 * 0.5 * error)
    assert found == pytest.approx(length, rel=4 * 2 * error)


def test_white_noise_does_not_wander_and_a_walk_does() -> None:
    """Steps of white noise have twice the variance of its deviations; those of a walk, 1 - rho of
    that. At five standard errors none of 1,000 captures of three darks is called a walk; of walks
    that forget in 8 frames, with as much white noise, nearly all are."""
    still = walks(3000, 0.0, 8.0, 2.0, seed=2)
    assert not any(wanders(still[k : k + 3]) for k in range(0, 3000, 3))
    moving = walks(300, 4.0, 8.0, 2.0, seed=3)
    told = sum(wanders(moving[k : k + 3]) for k in range(0, 300, 3))
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
        if told is None or told.base is None:
            continue
        assert told.base.clamp_e2 == 0.0
        # of 128 frames 3 are independent
        assert told.hints["frame_sigma_e"] == pytest.approx(12.0, rel=0.8)
        found = diagnose(taken, stated={"lamp": light()}, suspects=suspects()).report
        assert [e.name for e in found.effects] == ["black_level_drift"]
        assert found.gap.before > 0.5
        assert abs(found.gap.after) < 0.1


def test_what_walks_down_the_rows_is_told_by_their_means() -> None:
    """Logarithms of two figures, at 4 standard errors. These are the scatter of what as many series
    of such a process, with the read noise of a row on top, say of themselves; that of a length by
    itself has a long tail."""
    dark, dim, bright = (dataclasses.replace(shot, frames=64) for shot in PROTOCOL.shot)
    protocol = dataclasses.replace(PROTOCOL, shot=(dark, dim, bright))
    length, sigma_e = 12.0, 9.0
    walking = BlackLevelDrift(row_sigma_e=sigma_e, row_length=length, frame_sigma_e=0.0)
    made = camera().plus(walking).with_body(7)
    taken = record(made, protocol, {"lamp": light().rate_e_per_s}, seed=7)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    told = wandering(setting)
    assert told is not None
    assert told.base is not None
    assert told.base.clamp_e2 == 0.0
    white_e = 30.0 / np.sqrt(made.width / 2)
    drawn = [walks(64, sigma_e, length / 2, white_e, seed, made.height // 2) for seed in range(60)]
    errors = np.std(np.log([walk(one) for one in drawn]), axis=0)
    found = [told.hints["row_sigma_e"], told.hints["row_length"]]
    off = np.log(np.asarray(found, dtype=float) / [sigma_e, length])
    assert (np.abs(off) < 4 * errors).all()


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
