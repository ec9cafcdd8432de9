"""Effects of the photosite and of charge transfer: one closed form each, which an impostor fails.

The impostors have the effect's mean, variance or width, and lack its physics.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy import ndimage, stats

from sensor.effect import Effect
from sensor.effects.blooming import Blooming
from sensor.effects.brighter_fatter import BrighterFatter
from sensor.effects.charge_transfer_inefficiency import ChargeTransferInefficiency
from sensor.effects.crosstalk import Crosstalk
from sensor.effects.dark_current import DarkCurrent
from sensor.effects.hot_pixels import HotPixels
from sensor.effects.image_lag import ImageLag
from sensor.effects.large_scale_prnu import LargeScalePrnu
from sensor.effects.nonlinearity import Nonlinearity
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise
from sensor.effects.smear import Smear
from sensor.effects.spectral_response_error import SpectralResponseError
from tests.effects_bench import EXPOSURE_S, INTERVAL_S, READ_E, Array, flat, frames_of, rate_of
from tests.harness import assert_agree, variance_error

NOISE = READ_E**2 + 1 / 12
"""Variance in e-^2 that the bench itself adds to every pixel: read noise and rounding."""


def must_fail(check: Callable[..., None], *impostor: object) -> None:
    """The check refuses the impostor; one that lets it pass would show nothing."""
    with pytest.raises(AssertionError):
        check(*impostor)


def residuals(frames: Array) -> Array:
    """Frames less their mean, scaled so that mean squares are variances without bias."""
    return (frames - frames.mean(0)) * math.sqrt(len(frames) / (len(frames) - 1))


def lagged(noise: Array, dy: int, dx: int) -> float:
    """Mean product of noise with itself dy below and dx to the right."""
    _, height, width = noise.shape
    return float((noise[:, : height - dy, : width - dx] * noise[:, dy:, dx:]).mean())


def lagged_error(variance: float, frames: Array) -> float:
    """Standard error of such a mean: variance / sqrt(n); 5 % more for what is slightly correlated.

    Bartlett's sum of squared correlations stays below 1.1 for every case here.
    """
    samples = (len(frames) - 1) * (frames.shape[1] - 1) * (frames.shape[2] - 1)
    return 1.05 * variance / math.sqrt(samples)


def gaussian(like: Array, mean: object, variance: object, seed: int = 5) -> Array:
    """Independent Gaussian frames of a given mean and variance."""
    noise = np.random.default_rng(seed).standard_normal(like.shape)
    return np.asarray(mean) + np.sqrt(np.asarray(variance)) * noise


def test_spectral_response_error_mixes_light_and_not_noise() -> None:
    light = np.array([9000.0, 4000.0, 2000.0])
    leak = 0.1
    expected = (1 - 2 * leak) * light + leak * (light.sum() - light)
    rate = rate_of(np.broadcast_to(light, (64, 96, 3)))
    sites = (slice(0, None, 2), slice(0, None, 2)), (slice(0, None, 2), slice(1, None, 2))
    sites += ((slice(1, None, 2), slice(1, None, 2)),)

    def check(frames: Array) -> None:
        at = [frames[:, y, x] for y, x in sites]
        n = at[0].size
        assert_agree(
            [a.mean() for a in at] + [a.var(0, ddof=1).mean() for a in at],
            [*expected, *(expected + NOISE)],
            [*np.sqrt((expected + NOISE) / n), *variance_error(expected + NOISE, n - n // 16)],
        )

    check(frames_of(SpectralResponseError(leakage=leak), rate=rate, cfa="RGGB"))
    finished = frames_of(rate=rate, cfa="RGGB")
    for (y, x), before, after in zip(sites, light, expected, strict=True):
        finished[:, y, x] *= after / before
    must_fail(check, finished)
    grey = frames_of(rate=flat(5000), cfa="RGGB")
    assert np.abs(frames_of(SpectralResponseError(), rate=flat(5000), cfa="RGGB") - grey).max() <= 1


def test_crosstalk_smears_an_edge_and_leaves_the_noise_white() -> None:
    low, high, share = 2000.0, 12_000.0, 0.2
    image = np.full((64, 96), low)
    image[:, 48:] = high
    profile = np.array([low, low, high, high])
    profile[1:3] += share / 4 * (high - low) * np.array([1, -1])

    def check(frames: Array) -> None:
        columns = frames[:, :, 46:50]
        n = columns[..., 0].size
        variance = profile + NOISE
        assert_agree(columns.mean((0, 1)), profile, np.sqrt(variance / n), "edge")
        got = columns.var(0, ddof=1).mean(0)
        assert_agree(got, variance, variance_error(variance, n - 64), "shot noise")
        noise = residuals(frames[:, :, 52:])
        error = lagged_error(high + NOISE, noise)
        assert_agree([lagged(noise, 0, 1), lagged(noise, 1, 0)], [0, 0], error, "white")

    check(frames_of(Crosstalk(share=share), rate=rate_of(image)))
    kernel = np.array([[0, share / 4, 0], [share / 4, 1 - share, share / 4], [0, share / 4, 0]])
    must_fail(check, ndimage.convolve(frames_of(rate=rate_of(image)), kernel[None]))


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


def test_brighter_fatter_covariances_grow_with_the_square_of_the_mean() -> None:
    a_row, a_column = 4e-6, 8e-6
    means = (4000.0, 16_000.0)

    def strengths(mean: float) -> tuple[float, float]:
        return a_row * mean / 2, a_column * mean / 2

    def check(*stacks: Array) -> None:
        for mean, frames in zip(means, stacks, strict=True):
            h, v = strengths(mean)
            kept = 1 - 2 * h - 2 * v
            noise = residuals(frames[:, 2:-2, 2:-2])
            error = lagged_error(mean, noise)
            expected = mean * np.array([2 * h * kept, 2 * v * kept, 2 * h * v])
            got = [lagged(noise, 0, 1), lagged(noise, 1, 0), lagged(noise, 1, 1)]
            assert_agree(got, expected, error, f"covariances at {mean:g} e-")
            variance = mean * (kept**2 + 2 * h * h + 2 * v * v) + NOISE
            assert_agree((noise**2).mean(), variance, math.sqrt(2) * error, "variance")
            assert_agree(frames.mean(), mean, math.sqrt(mean / frames.size), "flux")

    effect = BrighterFatter(horizontal_per_e=a_row, vertical_per_e=a_column)
    check(*(frames_of(effect, rate=flat(m, 96, 128), frames=24) for m in means))
    h, v = strengths(means[1])
    kernel = np.array([[0, v, 0], [h, 1 - 2 * h - 2 * v, h], [0, v, 0]])
    plain = [frames_of(rate=flat(m, 96, 128), frames=24) for m in means]
    must_fail(check, *(ndimage.convolve(stack, kernel[None]) for stack in plain))
    must_fail(check, *plain)


def test_nonlinearity_bends_the_photon_transfer_curve() -> None:
    full, a, b = 16_000.0, 0.1, 0.05
    effect = Nonlinearity(quadratic_ratio=a, cubic_ratio=b, full_well_e=full)
    levels = full * np.array([0.2, 0.5, 0.8])
    x = levels / full
    # E[Q^2] and E[Q^3] of a Poisson count
    square, cube = levels**2 + levels, levels**3 + 3 * levels**2 + levels
    means = levels - a / full * square - b / full**2 * cube
    variances = levels * (1 - 2 * a * x - 3 * b * x**2) ** 2 + NOISE

    def check(*stacks: Array) -> None:
        n = stacks[0].size
        assert_agree([f.mean() for f in stacks], means, np.sqrt(variances / n), "mean")
        got = [f.var(0, ddof=1).mean() for f in stacks]
        assert_agree(got, variances, variance_error(variances, n - n // len(stacks[0])), "slope")

    check(*(frames_of(effect, rate=flat(level)) for level in levels))
    must_fail(check, *(frames_of(rate=flat(mean)) for mean in means))


def test_blooming_fills_the_column_to_full_well_and_keeps_its_charge() -> None:
    full, dim, bright = 14_000.0, 4000.0, 40_000.0
    image = np.full((64, 96), dim)
    image[28:36, 40:50] = bright
    before = frames_of(rate=rate_of(image))

    def check(frames: Array) -> None:
        change = frames - before
        # read noise is the same draw in both, so only the two roundings are left: 1/6 each
        loss = change.sum(1)
        assert_agree(loss, 0, math.sqrt(64 / 6), "charge of every column")
        assert np.array_equal(frames[:, :, :40], before[:, :, :40])
        assert np.array_equal(frames[:, :, 50:], before[:, :, 50:])
        # each side takes 4 rows' excess of 26000 e- at 10000 e- a row: 10.4 rows
        plateau = frames[:, 19:45, 40:50]
        assert_agree(plateau.mean((1, 2)), full, math.sqrt(NOISE / plateau[0].size), "plateau")
        got = plateau.var(ddof=1)
        assert_agree(
            got, NOISE, variance_error(NOISE, plateau.size), "full well without shot noise"
        )
        above, below = (frames[:, rows, 40:50].sum(1) for rows in (slice(28), slice(36, None)))
        error = math.sqrt((56 * (dim + NOISE) + 8 * bright) / above.size)
        assert_agree((above - below).mean(), 0, error, "symmetric")

    check(frames_of(Blooming(full_well_e=full, drained=0.0), rate=rate_of(image)))
    must_fail(check, ndimage.gaussian_filter1d(before, 8.0, axis=1))
    must_fail(check, np.minimum(before, full))
    drained = frames_of(Blooming(full_well_e=full, drained=0.75), rate=rate_of(image))
    excess = np.maximum(before[:, 28:36, 40:50] - full, 0)
    got = (drained - before).sum((1, 2))
    # `before` holds the read noise, which the well does not: 80 draws of it enter the excess
    assert_agree(got, -0.75 * excess.sum((1, 2)), math.sqrt(640 / 6 + 0.75**2 * 80 * NOISE))


def test_image_lag_remembers_in_time_and_not_in_space() -> None:
    light, f = 9000.0, 0.1
    effect = ImageLag(fraction=f)
    variance = light * (1 - f) / (1 + f)

    def check(frames: Array) -> None:
        noise = frames - light
        total = variance + NOISE
        in_time = [float((noise[k:] * noise[: len(noise) - k]).mean()) for k in (0, 1, 2, 3)]
        in_space = [lagged(noise, 0, 1), lagged(noise, 1, 0)]
        error = lagged_error(total, noise)
        assert_agree(
            in_time + in_space,
            [total, *(variance * f**k for k in (1, 2, 3)), 0, 0],
            [math.sqrt(2) * error, *[error] * 5],
        )

    frames = frames_of(effect, rate=flat(light), frames=60)
    check(frames)
    must_fail(check, gaussian(frames, light, variance + NOISE))
    must_fail(check, np.random.default_rng(5).permuted(frames, axis=0))


def test_smear_runs_through_the_whole_column_with_its_own_shot_noise() -> None:
    dim, bright, leak, transfer = 200.0, 20_000.0, 0.02, 1 / 15
    image = np.full((64, 96), dim)
    image[24:40, 40:56] = bright
    effect = Smear(leak_ratio=leak, transfer_s=transfer)

    def check(frames: Array, exposure_s: float) -> None:
        charge = image * exposure_s / EXPOSURE_S
        added = leak * transfer / exposure_s * charge.mean(0)
        for rows in (slice(0, 24), slice(40, 64)):
            for columns in (slice(0, 40), slice(40, 56)):
                part = frames[:, rows, columns]
                mean = charge[0, 0] + added[columns][0]
                # the light of the column is itself a count: shared by all rows of a frame
                shared = (leak * transfer / exposure_s) ** 2 * charge.mean(0)[columns][0] / 64
                variance = mean + NOISE + shared
                shared_error = shared / (len(part) * part.shape[2])
                error = math.sqrt((mean + NOISE) / part.size + shared_error)
                assert_agree(part.mean(), mean, error, "rise")
                got = part.var(0, ddof=1).mean()
                # counts near 250 have excess kurtosis 1/250: nothing beside 2
                n = part.size * (1 - 1 / len(part))
                assert_agree(got, variance, variance_error(variance, round(n)), "shot noise")

    for exposure_s in (EXPOSURE_S, EXPOSURE_S / 2):
        options = {"rate": rate_of(image), "exposure_s": exposure_s}
        check(frames_of(effect, **options), exposure_s)
        charge = image * exposure_s / EXPOSURE_S
        offset = leak * transfer / exposure_s * charge.mean(0)
        plain = frames_of(**options)
        must_fail(check, plain + offset, exposure_s)
        must_fail(check, gaussian(plain, plain.mean(0) + offset.mean(), plain.var(0)), exposure_s)
    dark = frames_of(rate=rate_of(image), level=0.0)
    assert np.array_equal(frames_of(effect, rate=rate_of(image), level=0.0), dark)


@pytest.mark.parametrize("beta", [1.0, 0.5])
@pytest.mark.parametrize("axis", [0, 1])
def test_charge_trails_away_from_the_output_alone(axis: int, beta: float) -> None:
    per_transfer, count = 2e-4, 24
    profile = np.full(96, 1000.0)
    profile[40:48] = 10_000.0
    image = np.broadcast_to(profile, (64, 96))
    share = np.minimum(np.arange(1, 97) * per_transfer * (profile / 1e4) ** (beta - 1), 0.5)
    left = profile * share
    expected = profile - left + np.concatenate([[0.0], left[:-1]])
    rates = {"vertical_per_transfer": 0.0, "horizontal_per_transfer": 0.0, "beta": beta}
    rates["horizontal_per_transfer" if axis else "vertical_per_transfer"] = per_transfer

    def turned(stack: Array) -> Array:
        return stack if axis else stack.swapaxes(1, 2)

    def check(frames: Array) -> None:
        variance = profile + NOISE
        error = np.sqrt(variance / (count * 64))
        assert_agree(frames.mean((0, 1)), expected, error, "trail")

    rate = rate_of(image if axis else image.T)
    frames = turned(frames_of(ChargeTransferInefficiency(**rates), rate=rate, frames=count))
    check(frames)
    plain = turned(frames_of(rate=rate, frames=count))
    moved = plain * share
    symmetric = plain - moved + (np.roll(moved, 1, axis=2) + np.roll(moved, -1, axis=2)) / 2
    must_fail(check, symmetric)
    must_fail(check, plain)
    # the same draws with and without: what is missing went to the overscan
    missing = (plain - frames).sum(2).mean()
    error = math.sqrt((96 / 6 + 1000 * share[-1] ** 2) / (count * 64))
    assert_agree(missing, left[-1], error, "charge is kept")
