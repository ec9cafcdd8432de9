"""What a photosite has of its own, in every frame: one closed form each, which an impostor fails.

The impostors have the effect's mean, variance or width, and lack its physics.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy import stats

from sensor.effect import Effect
from sensor.effects.dark_current import DarkCurrent
from sensor.effects.hot_pixels import HotPixels
from sensor.effects.large_scale_prnu import LargeScalePrnu
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise
from tests.charge_bench import NOISE, gaussian, must_fail
from tests.effects_bench import EXPOSURE_S, INTERVAL_S, READ_E, Array, flat, frames_of, rate_of
from tests.harness import assert_agree, variance_error


def test_dark_current_is_charge_that_grows_with_time_and_warmth_and_is_skewed() -> None:
    rate_e, spread, count = 50_000.0, 0.5, 24
    s2 = math.log(1 + spread**2)

    def frames(exposure_s: float, temperature_c: float) -> Array:
        effect = DarkCurrent(mean_e_per_s=rate_e, spread=spread)
        options = {"exposure_s": exposure_s, "temperature_c": temperature_c}
        return frames_of(effect, rate=flat(0), level=0.0, frames=count, **options)

    def check(once: Array, longer: Array, warmer: Array) -> None:
        pattern = once.mean(0)
        mean = rate_e * EXPOSURE_S
        error = mean * spread / math.sqrt(pattern.size)
        assert_agree(pattern.mean(), mean, error, "mean")
        for more in (longer, warmer):
            error = math.sqrt((2 * mean + 4 * mean + 5 * NOISE) / once.size)
            assert_agree(more.mean() - 2 * once.mean(), 0, error, "doubled")
        logs = np.log(np.maximum(pattern, 1.0))
        assert_agree(
            [logs.var(ddof=1), stats.skew(logs, axis=None)],
            [s2, 0],
            [variance_error(s2, logs.size), math.sqrt(6 / logs.size)],
            "log-normal",
        )
        bright = pattern > np.median(pattern)
        for half in (bright, ~bright):
            variance = once.var(0, ddof=1)[half]
            expected = pattern[half] + NOISE
            error = math.sqrt((2 * expected**2 / (count - 1)).sum()) / half.sum()
            assert_agree(variance.mean(), expected.mean(), error, "drawn")

    three = frames(EXPOSURE_S, 29), frames(2 * EXPOSURE_S, 29), frames(EXPOSURE_S, 37)
    check(*three)
    rng = np.random.default_rng(5)
    offsets = np.maximum(rng.normal(1, spread, three[0].shape[1:]), 0.01)
    must_fail(check, *(gaussian(f, f.mean() * offsets, f.mean() + NOISE) for f in three))


def test_hot_pixels_stay_where_they_are_and_grow_with_the_exposure() -> None:
    density, rate_e, count = 0.01, 100_000.0, 24
    effect = HotPixels(density=density, rate_e_per_s=rate_e)

    def frames(exposure_s: float) -> Array:
        options = {"exposure_s": exposure_s, "frames": count, "level": 0.0}
        return frames_of(effect, rate=flat(0), label=f"{exposure_s}", **options)

    def check(once: Array, longer: Array) -> None:
        first, second = once.mean(0), longer.mean(0)
        threshold = 60.0  # twelve standard deviations of the read noise of a single frame
        hot = first > threshold
        expected = density * math.exp(-threshold / (rate_e * EXPOSURE_S))
        error = math.sqrt(expected / hot.size)
        assert_agree(hot.mean(), expected, error, "density")
        error = np.sqrt((second[hot] + 4 * first[hot] + 5 * NOISE) / count)
        assert_agree(second[hot] - 2 * first[hot], 0, error, "exposure")
        variance, own = longer.var(0, ddof=1)[hot], second[hot] + NOISE
        # Poisson counts of these means are Gaussian to a thousandth, so 2 v^2 / (n - 1) holds
        error = math.sqrt((2 * own**2 / (count - 1)).sum())
        assert_agree(variance.sum(), own.sum(), error, "drawn")

    both = frames(EXPOSURE_S), frames(2 * EXPOSURE_S)
    check(*both)
    rng = np.random.default_rng(5)
    moving = [
        np.stack([rng.permutation(frame.ravel()).reshape(frame.shape) for frame in stack])
        for stack in both
    ]
    must_fail(check, *moving)


@pytest.mark.parametrize(("up_s", "down_s"), [(0.25, 0.5), (2.0, 1.5), (0.04, 0.06)])
def test_telegraph_noise_forgets_at_the_rate_of_its_dwell_times(up_s: float, down_s: float) -> None:
    """The structure function of the chain: 2 A^2 p (1 - p) (1 - exp(-k interval / tau))."""
    effect = RandomTelegraphNoise(
        fraction=0.2, amplitude_e=400, dwell_up_s=up_s, dwell_down_s=down_s
    )
    decay = math.exp(-INTERVAL_S / effect.tau_s)
    lags, last = np.array([1, 2, 4]), 8

    def check(frames: Array) -> None:
        def spread(k: int) -> Array:
            """By row of pixels, above the bench's own noise."""
            return ((frames[k:] - frames[:-k]) ** 2).mean((0, 2)) - 2 * NOISE

        expected = (1 - decay**lags) / (1 - decay**last)
        # zero in the mean where the chain is right, so rows give its standard error
        excess = np.array(
            [spread(k) - e * spread(last) for k, e in zip(lags, expected, strict=True)]
        )
        assert_agree(excess.mean(1), 0, excess.std(1, ddof=1) / math.sqrt(frames.shape[1]))
        assert spread(last).mean() > 100 * NOISE

    frames = frames_of(effect, rate=flat(0, 96, 64), level=0.0, frames=80)
    check(frames)
    if decay > 0.1:
        must_fail(check, np.random.default_rng(5).permuted(frames, axis=0))


def test_telegraph_noise_has_two_levels_and_the_share_of_its_dwell_times() -> None:
    effect = RandomTelegraphNoise(fraction=0.03, amplitude_e=1000, dwell_up_s=0.1, dwell_down_s=0.2)

    def check(frames: Array) -> None:
        low, high = frames.min(0), frames.max(0)
        seen = high - low > 150
        place = ((frames - low) / (high - low))[:, seen]
        within = 6 * READ_E / (high - low)[seen]
        assert ((place < 2 * within) | (place > 1 - 2 * within)).all()
        up = (place > 0.5).mean(0)
        assert_agree(up.mean(), effect.share_up, up.std(ddof=1) / math.sqrt(seen.sum()))

    frames = frames_of(effect, rate=flat(0), level=0.0, frames=150, body_seed=3)
    check(frames)
    must_fail(check, gaussian(frames, frames.mean(0), frames.var(0)))


@pytest.mark.parametrize(
    ("spread", "lognormal", "mean_square"),
    [(1.0, 0.0, 2.0), (0.5, 0.0, 4 / math.pi), (0.0, 0.0, 1.0), (0.6, 1.0, math.exp(0.36))],
)
def test_traps_differ_by_their_law(spread: float, lognormal: float, mean_square: float) -> None:
    """Gamma(1 + 2 s) / Gamma(1 + s)^2 of a power of an exponential: 2 for 1, 4 / pi for 1/2, 1 for
    0; exp(s^2) of a lognormal. By rows of pixels, which give the standard error; every law fails
    where the square of another one is expected."""
    effect = RandomTelegraphNoise(
        fraction=0.3,
        amplitude_e=1000,
        dwell_up_s=0.1,
        dwell_down_s=0.1,
        spread=spread,
        lognormal=lognormal,
    )
    frames = frames_of(effect, rate=flat(0, 96, 64), level=0.0, frames=120)

    def check(mean_square: float) -> None:
        # differences of frames far apart: 2 A^2 p (1 - p) and the bench's own noise
        squares = (frames[40:] - frames[:-40]) ** 2
        excess = squares.mean((0, 2)) - 2 * NOISE
        expected = 0.3 * 0.5 * 1000.0**2 * mean_square
        assert_agree(excess.mean(), expected, excess.std(ddof=1) / math.sqrt(len(excess)))

    check(mean_square)
    must_fail(check, 2.0 if mean_square < 1.5 else 1.0)


def test_traps_that_make_dark_current_make_more_in_time_and_warmth() -> None:
    """A trap that is up in all frames and the same everywhere adds charge in proportion to the
    exposure and twice as much 8 degrees warmer, with a variance of its mean; one in the output adds
    none."""
    traps = RandomTelegraphNoise(
        fraction=0.3, amplitude_e=5000, dwell_up_s=1000, dwell_down_s=0.001, spread=0.0
    )

    def check(effect: RandomTelegraphNoise) -> None:
        for times, warmer_c in ((1, 0), (3, 0), (1, 8)):
            warmth = {"exposure_s": times * EXPOSURE_S, "temperature_c": 29.0 + warmer_c}
            frames = frames_of(effect, rate=flat(0, 96, 64), level=0.0, frames=64, **warmth)
            expected = 5000 * times * EXPOSURE_S / 0.1 * 2 ** (warmer_c / 8)
            up = frames.min(0) > expected / 2
            means, variances = frames.mean(0)[up], frames.var(0, ddof=1)[up]
            noise = expected + NOISE
            assert_agree(means.mean(), expected, math.sqrt(noise / (up.sum() * 64)))
            assert_agree(variances.mean(), noise, variance_error(noise, up.sum() * 63))

    check(dataclasses.replace(traps, of_dark_current=1.0))
    must_fail(check, traps)


def test_large_scale_prnu_is_one_system_of_rings() -> None:
    """With direction, phase and amplitude fitted, nothing is left but the shot noise."""
    light, ratio, period, count = 40_000.0, 0.01, 25.0, 16
    effect = LargeScalePrnu(ring_ratio=ratio, ring_period_px=period, edge_ratio=0.0)
    y, x = np.mgrid[:64, :96].astype(float)
    far = 1.5 * math.hypot(64, 96)

    def fit(response: Array, angle: float) -> tuple[Array, Array]:
        r = np.hypot(y - 32 - far * math.sin(angle), x - 48 - far * math.cos(angle))
        turn = 2 * math.pi * r / period
        basis = np.stack([np.ones(r.size), np.cos(turn).ravel(), np.sin(turn).ravel()], 1)
        terms, *_ = np.linalg.lstsq(basis, response.ravel(), rcond=None)
        return terms, response.ravel() - basis @ terms

    def check(frames: Array) -> None:
        response = frames.mean(0) / light
        angles = np.linspace(0, 2 * math.pi, 240, endpoint=False)
        best = min(angles, key=lambda a: (fit(response, a)[1] ** 2).sum())
        fine = np.linspace(best - 0.03, best + 0.03, 121)
        best = min(fine, key=lambda a: (fit(response, a)[1] ** 2).sum())
        terms, left = fit(response, best)
        variance = (light + NOISE) / count / light**2
        dof = left.size - 4
        amplitude = math.hypot(terms[1], terms[2])
        assert_agree(
            [terms[0], amplitude, (left**2).sum() / dof],
            [1, math.sqrt(2) * ratio, variance],
            [
                math.sqrt(variance / left.size),
                math.sqrt(2 * variance / left.size),
                variance_error(variance, dof + 1),
            ],
        )

    check(frames_of(effect, rate=flat(light), frames=count))
    scattered = np.random.default_rng(5).normal(1, ratio, (64, 96))
    must_fail(check, frames_of(rate=rate_of(light * scattered), frames=count))


def test_large_scale_prnu_falls_off_at_the_edges() -> None:
    light, loss = 40_000.0, 0.1
    effect = LargeScalePrnu(ring_ratio=0.0, edge_ratio=loss)
    mean = frames_of(effect, rate=flat(light)).mean(0)
    y, x = np.mgrid[:64, :96]
    inwards = np.minimum(np.minimum(y, 63 - y), np.minimum(x, 95 - x))
    got = [mean[inwards == d].mean() for d in range(30)]
    expected = light * (1 - loss * np.exp(-np.arange(30) / 15))
    errors = [math.sqrt((light + NOISE) / 16 / (inwards == d).sum()) for d in range(30)]
    assert_agree(got, expected, errors)


def test_slow_waves_are_alike_over_their_length() -> None:
    """Over many bodies a normal correlation of that length, and their variance."""
    light, ratio, length, bodies = 40_000.0, 0.05, 6.0, 40
    effect = LargeScalePrnu(
        ring_ratio=0.0, edge_ratio=0.0, field_ratio=ratio, field_length_px=length
    )
    lags = (0, 3, 6, 12)

    def check(responses: Array) -> None:
        noise = (light + NOISE) / 2 / light**2
        pattern = (responses - 1) / ratio
        found = []
        for lag in lags:
            product = (pattern[:, :, : 96 - lag] * pattern[:, :, lag:]).mean((1, 2))
            found.append(product - (noise / ratio**2 if lag == 0 else 0.0))
        means, errors = np.mean(found, axis=1), np.std(found, axis=1, ddof=1) / math.sqrt(bodies)
        assert_agree(means, [math.exp(-((lag / length) ** 2) / 2) for lag in lags], errors)

    def responses(*effects: Effect, rates: Sequence[Array]) -> Array:
        return np.stack(
            [
                frames_of(*effects, rate=rate, frames=2, body_seed=k).mean(0) / light
                for k, rate in enumerate(rates)
            ]
        )

    check(responses(effect, rates=[flat(light)] * bodies))
    draw = np.random.default_rng(8)
    scattered = [rate_of(light * draw.normal(1, ratio, (64, 96))) for _ in range(bodies)]
    must_fail(check, responses(rates=scattered))
