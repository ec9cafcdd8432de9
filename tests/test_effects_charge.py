"""Charge between photosites and on its way out: one closed form each, which an impostor fails.

The impostors have the effect's mean, variance or width, and lack its physics.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

from sensor.effects.blooming import Blooming
from sensor.effects.brighter_fatter import BrighterFatter
from sensor.effects.charge_transfer_inefficiency import ChargeTransferInefficiency
from sensor.effects.crosstalk import Crosstalk
from sensor.effects.image_lag import ImageLag
from sensor.effects.nonlinearity import Nonlinearity
from sensor.effects.smear import Smear
from sensor.effects.spectral_response_error import SpectralResponseError
from tests.charge_bench import NOISE, gaussian, lagged, lagged_error, must_fail, residuals
from tests.effects_bench import EXPOSURE_S, Array, flat, frames_of, rate_of
from tests.harness import assert_agree, variance_error


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
    uneven = frames_of(Crosstalk(share=share, along_rows=0.8), rate=rate_of(image)).mean(0)
    # 0.8 / 2 of the share to each side instead of a quarter
    step = share * 0.4 * (high - low)
    error = math.sqrt((high + NOISE) / (16 * 64))
    assert_agree(uneven[:, 47].mean() - low, step, error, "along rows")
    point = np.full((64, 96), low)
    point[8:-8:8, 8:-8:8] = high
    cornered = frames_of(Crosstalk(share=share, to_corners=0.2), rate=rate_of(point)).mean(0)
    parts = [cornered[8 + dy : -8 : 8, 8 + dx : -8 : 8].mean() for dy, dx in ((0, 1), (1, 1))]
    points = point[8:-8:8, 8:-8:8].size
    # a fifth of the share to four corners, and four fifths to four sides
    expected = low + share * (high - low) * np.array([0.8 / 4, 0.2 / 4])
    assert_agree(parts, expected, np.sqrt((expected + NOISE) / (16 * points)), "corners")
    kernel = np.array([[0, share / 4, 0], [share / 4, 1 - share, share / 4], [0, share / 4, 0]])
    must_fail(check, ndimage.convolve(frames_of(rate=rate_of(image)), kernel[None]))


def test_crosstalk_out_of_the_depth_leaves_red_sites_and_comes_to_blue_ones() -> None:
    """Under even grey light a red site gives 1 + d to greens that give 1, a blue one 1 - d, and a
    green one of a red row gets the difference in its row and in its column: nothing is lost, and
    impostors that bleach red sites alone lose it."""
    even, share, along, deeper = 9000.0, 0.2, 0.8, 0.3
    more = share * deeper * np.array([[-1.0, 2 * along - 1], [1 - 2 * along, 1.0]])
    expected = even * (1 + more)

    def check(frames: Array) -> None:
        mosaic = frames[:, 2:-2, 2:-2]
        at = [mosaic[:, y::2, x::2] for y in (0, 1) for x in (0, 1)]
        n = at[0].size
        flat_expected = expected.ravel()
        assert_agree(
            [a.mean() for a in at] + [a.var(0, ddof=1).mean() for a in at],
            [*flat_expected, *(flat_expected + NOISE)],
            [
                *np.sqrt((flat_expected + NOISE) / n),
                *variance_error(flat_expected + NOISE, n - n // 16),
            ],
        )

    effect = Crosstalk(share=share, along_rows=along, deeper_in_red=deeper)
    check(frames_of(effect, rate=flat(even), cfa="RGGB"))
    bleached = frames_of(rate=flat(even), cfa="RGGB")
    bleached[:, ::2, ::2] *= 1 - share * deeper
    must_fail(check, bleached)


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


def test_a_drain_on_the_way_leaves_the_ends_what_a_few_rows_spill() -> None:
    full, dim, excess, high, reach = 14_000.0, 4000.0, 2000.0, 20, 3.0
    image = np.full((64, 96), dim)
    image[22 : 22 + high] = full + excess
    passing = math.exp(-1 / reach)
    runs_out = excess / 2 * (1 - passing**high) / (1 - passing)

    def check(frames: Array) -> None:
        beside = np.stack([frames[:, 21].ravel(), frames[:, 22 + high].ravel()])
        variance = dim + NOISE + (full + excess) / 4 / (1 - passing**2)
        assert_agree(beside.mean(1), dim + runs_out, math.sqrt(variance / beside[0].size), "ends")
        assert_agree(frames[:, :20].mean(), dim, math.sqrt((dim + NOISE) / frames[:, :20].size))

    rate = rate_of(image)
    effect = Blooming(full_well_e=full, drained=0.0, reach_rows=reach)
    check(frames_of(effect, rate=rate, frames=64))
    must_fail(check, frames_of(Blooming(full_well_e=full, drained=0.0), rate=rate, frames=64))
    must_fail(check, frames_of(Blooming(full_well_e=full, drained=0.3), rate=rate, frames=64))


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


def test_an_image_lag_of_single_electrons_is_poisson_and_has_no_memory() -> None:
    """What stays of a Poisson process and what goes are two of them, independent of each other."""
    light, f = 9000.0, 0.1

    def check(frames: Array) -> None:
        noise = frames - light
        total = light + NOISE
        in_time = [float((noise[k:] * noise[: len(noise) - k]).mean()) for k in (0, 1, 2)]
        error = lagged_error(total, noise)
        assert_agree(in_time, [total, 0, 0], [math.sqrt(2) * error, error, error])

    check(frames_of(ImageLag(fraction=f, by_chance=1.0), rate=flat(light), frames=60))
    must_fail(check, frames_of(ImageLag(fraction=f), rate=flat(light), frames=60))


@pytest.mark.parametrize("by_chance", [0.0, 1.0])
def test_a_shot_that_begins_in_the_dark_lacks_what_stays_behind(by_chance: float) -> None:
    """f of the mean of the first frame, f^2 of the second, f^3 of the third."""
    light, f = 9000.0, 0.1
    effect = ImageLag(fraction=f, by_chance=by_chance, from_dark=1.0)

    def check(frames: Array) -> None:
        lacks = light - frames[:3].mean(axis=(1, 2))
        error = math.sqrt((light + NOISE) / frames[0].size)
        assert_agree(lacks, [light * f**k for k in (1, 2, 3)], [error] * 3)

    check(frames_of(effect, rate=flat(light), frames=8))
    must_fail(check, frames_of(ImageLag(fraction=f), rate=flat(light), frames=8))


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
