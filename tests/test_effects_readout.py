"""Readout and converter: what follows from each equation, and that an impostor fails it."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from sensor.effects.adc_dnl import AdcDnl, weighed, widths
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.column_fpn import ColumnFpn
from sensor.effects.flicker_noise import FlickerNoise
from sensor.effects.fpn import Fpn
from sensor.effects.interference import Interference
from sensor.effects.quantization import Quantization
from sensor.effects.row_noise import RowNoise
from tests.effects_bench import READ_E, Array, flat, frames_of
from tests.effects_chain import (
    LIGHT_E,
    NOISE,
    ROUNDING,
    Figures,
    applied,
    by_frame,
    independent,
    tells_apart,
)
from tests.harness import assert_agree, variance_error


def test_row_noise_does_not_average_out_along_the_row() -> None:
    sigma = 20.0

    def figures(frames: Array) -> Figures:
        rows = frames.mean(2) - LIGHT_E
        inside = frames - frames.mean(2, keepdims=True)
        width = frames.shape[2]
        expected = [sigma**2 + (NOISE + ROUNDING) / width, NOISE + ROUNDING]
        error = [variance_error(expected[0], rows.size), variance_error(expected[1], frames.size)]
        return [np.mean(rows**2), np.mean(inside**2) * width / (width - 1)], expected, error

    rate = flat(LIGHT_E)
    real = frames_of(RowNoise(sigma_e=sigma), rate=rate)
    tells_apart(figures, real, frames_of(independent(sigma), rate=rate))


def test_column_fpn_does_not_average_out_down_the_column_nor_in_time() -> None:
    sigma = 20.0

    def figures(frames: Array) -> Figures:
        columns = frames.mean((0, 1)) - LIGHT_E
        count, height, width = frames.shape
        expected = [sigma**2 + NOISE / (count * height), NOISE + ROUNDING]
        errors = [variance_error(expected[0], width), variance_error(expected[1], frames.size)]
        return [np.mean(columns**2), frames.var(0, ddof=1).mean()], expected, errors

    rate = flat(LIGHT_E, 48, 256)
    real = frames_of(ColumnFpn(sigma_e=sigma), rate=rate)
    tells_apart(figures, real, frames_of(Fpn(sigma_e=sigma), rate=rate))
    again = frames_of(ColumnFpn(sigma_e=sigma), rate=rate, label="another", seed=9)
    error = math.sqrt(2 * NOISE / (len(real) * 48))
    assert_agree(real.mean((0, 1)) - again.mean((0, 1)), np.zeros(256), np.full(256, error))


def test_interference_has_all_its_power_at_one_frequency_and_moves_by_its_drift() -> None:
    amplitude, period, drift = 20.0, 23.7, 0.137

    def figures(frames: Array) -> Figures:
        series = frames.reshape(len(frames), -1) - LIGHT_E
        n = series.shape[1]
        wave = series @ np.exp(-2j * np.pi * np.arange(n) / period)
        power = np.mean(np.abs(wave) ** 2) / n
        step = np.angle(np.sum(wave[1:] * np.conj(wave[:-1]))) / (2 * np.pi)
        expected = amplitude**2 * n / 4 + NOISE + ROUNDING
        phase_error = math.sqrt(2 * NOISE / n) / amplitude  # of a frame, in radians
        errors = [
            2 * math.sqrt(expected * NOISE / 2 / len(frames)),
            math.sqrt(2) * phase_error / (len(frames) - 1) / (2 * np.pi),
        ]
        return [power, step], [expected, drift], errors

    rate = flat(LIGHT_E)
    effect = Interference(amplitude_e=amplitude, period_px=period, drift_cycles_per_frame=drift)
    impostor = frames_of(independent(amplitude / math.sqrt(2)), rate=rate)
    tells_apart(figures, frames_of(effect, rate=rate), impostor)


def test_blanking_turns_a_wave_from_row_to_row_and_jitter_from_frame_to_frame() -> None:
    """Lines of W + B pixels: every row's phase is ahead by (W + B) / P cycles. Of sources that do
    not keep time the phasors of n frames add up to n of n^2 in the mean of the square."""
    period, blanking = 23.7, 61.0

    def phases(effect: Interference, frames: int) -> Array:
        seen = frames_of(effect, rate=flat(LIGHT_E), frames=frames) - LIGHT_E
        wave = seen @ np.exp(-2j * np.pi * np.arange(seen.shape[2]) / period)
        return np.asarray(wave)

    rows = phases(Interference(amplitude_e=300.0, period_px=period, blanking_px=blanking), 4)
    turn = np.angle(np.sum(rows[:, 1:] * np.conj(rows[:, :-1]))) / (2 * np.pi)
    width = flat(LIGHT_E).shape[1]
    assert abs((turn - (width + blanking) / period + 0.5) % 1 - 0.5) < 0.005
    apart = {}
    for jitter in (0.0, 1.0):
        still = Interference(
            amplitude_e=300.0, period_px=period, drift_cycles_per_frame=0.0, jitter_cycles=jitter
        )
        wave = phases(still, 200)[:, 0]
        apart[jitter] = abs(np.sum(wave / np.abs(wave))) ** 2 / 200
    assert apart[0.0] > 190
    assert apart[1.0] < 12  # exponential, of mean 1: 6e-6


def test_a_source_that_runs_freely_loses_its_phase_frame_by_frame() -> None:
    """Of a walk of w cycles phasors m frames apart agree by exp(-2 pi^2 w^2 m): 0.82 and 0.67 for
    0.1. Sums over 400 frames that agree so scatter by 0.02 and 0.03; the bound is four of these.
    """
    period, walk = 23.7, 0.1
    effect = Interference(
        amplitude_e=300.0, period_px=period, drift_cycles_per_frame=0.0, walk_cycles=walk
    )
    seen = frames_of(effect, rate=flat(LIGHT_E), frames=400) - LIGHT_E
    wave = (seen @ np.exp(-2j * np.pi * np.arange(seen.shape[2]) / period))[:, 0]
    unit = wave / np.abs(wave)
    for lag, bound in ((1, 0.08), (2, 0.12)):
        agree = abs(np.mean(unit[lag:] * np.conj(unit[:-lag])))
        assert agree == pytest.approx(math.exp(-2 * (math.pi * walk) ** 2 * lag), abs=bound)


def of_traps(k: Array, slowest_turns: float, exponent: float = 1.0) -> Array:
    """Weights of waves of k turns that traps up to a time constant give them."""
    return np.asarray(np.arctan(2 * np.pi * k * slowest_turns) / k**exponent)


@pytest.mark.parametrize(("slowest_rows", "exponent"), [(1000.0, 1.0), (2.0, 1.0), (1000.0, 1.4)])
def test_flicker_noise_has_equal_power_in_every_octave_or_falls_faster(
    slowest_rows: float, exponent: float
) -> None:
    sigma, height, width = 60.0, 64, 128
    turns = np.arange(1, height * width // 2)
    law = of_traps(turns, slowest_rows / height, exponent)
    law *= sigma**2 * height * width / (2 * law.sum())
    edges = height * width // 2 ** np.arange(1, 10)[::-1]

    def figures(frames: Array) -> Figures:
        """Of each octave, two-sided, per pixel: the law and the bench's read noise."""
        series = frames.reshape(len(frames), -1)
        power = np.abs(np.fft.rfft(series)) ** 2 / series.shape[1]
        bands = list(itertools.pairwise(edges))
        measured, error = by_frame(np.stack([power[:, a:b].mean(1) for a, b in bands], axis=1))
        expected = [law[a - 1 : b - 1].mean() for a, b in bands]
        return measured, np.array(expected) + READ_E**2 + ROUNDING, error

    rate = flat(0.0, height, width)
    effect = FlickerNoise(sigma_e=sigma, slowest_rows=slowest_rows, exponent=exponent)
    real = frames_of(effect, rate=rate, frames=128)
    tells_apart(figures, real, frames_of(independent(sigma), rate=rate, frames=128))


def test_a_clamp_takes_the_mean_of_every_frame_off_or_none_of_it() -> None:
    sigma, height, width, slowest_rows = 60.0, 16, 128, 8.0
    pixels = height * width
    noise = (READ_E**2 + ROUNDING) / pixels
    k = np.arange(1, pixels + 1)
    power = of_traps(k, slowest_rows / (2 * height))
    seen = np.sin(np.pi * k / 2) / (pixels * np.sin(np.pi * k / (2 * pixels)))
    wander = sigma**2 * np.sum(power * seen**2) / np.sum(power)
    assert wander > 50 * noise
    for clamped, expected in ((1.0, noise), (0.0, noise + wander)):
        effect = FlickerNoise(sigma_e=sigma, slowest_rows=slowest_rows, clamped=clamped)
        means = frames_of(effect, rate=flat(0.0, height, width), frames=512).mean((1, 2))
        error = variance_error(expected, means.size)
        assert_agree([np.mean(means**2)], [expected], [error], f"clamped {clamped:g}")


def test_black_level_drift_is_remembered_down_the_rows() -> None:
    sigma, length, lags = 20.0, 8.0, [0, 1, 4, 8, 16]

    def figures(frames: Array) -> Figures:
        rows = frames.mean(2) - LIGHT_E
        high = rows.shape[1]
        measured = [(rows[:, : high - d] * rows[:, d:]).mean(1) for d in lags]
        expected = sigma**2 * np.exp(-np.array(lags) / length)
        expected[0] += NOISE / frames.shape[2]
        mean, error = by_frame(np.stack(measured, axis=1))
        return mean, expected, error

    rate = flat(LIGHT_E, 96, 64)
    effect = BlackLevelDrift(row_sigma_e=sigma, row_length=length, frame_sigma_e=0.0)
    real = frames_of(effect, rate=rate, frames=128)
    tells_apart(figures, real, frames_of(RowNoise(sigma_e=sigma), rate=rate, frames=128))


def test_black_level_drift_is_remembered_along_the_shot() -> None:
    sigma, length, lags, height = 20.0, 3.0, [0, 1, 3, 6], 16

    def figures(frames: Array) -> Figures:
        means = frames.mean((1, 2)) - LIGHT_E
        blocks = means.reshape(-1, 60)  # twenty memories long: as good as independent
        measured = [(blocks[:, : 60 - d] * blocks[:, d:]).mean(1) for d in lags]
        expected = sigma**2 * np.exp(-np.array(lags) / length)
        expected[0] += NOISE / frames[0].size
        mean, error = by_frame(np.stack(measured, axis=1))
        return mean, expected, error

    rate = flat(LIGHT_E, height, 16)
    effect = BlackLevelDrift(row_sigma_e=0.0, frame_sigma_e=sigma, frame_length=length)
    real = frames_of(effect, rate=rate, frames=6000)
    # rows drawn afresh whose frame means spread as much
    impostor = RowNoise(sigma_e=sigma * math.sqrt(height))
    tells_apart(figures, real, frames_of(impostor, rate=rate, frames=6000))


def test_black_level_offset_moves_means_and_no_variance() -> None:
    offset = 66.0

    def figures(frames: Array) -> Figures:
        expected = [LIGHT_E + offset, NOISE + ROUNDING]
        errors = [math.sqrt(NOISE / frames.size), variance_error(NOISE, frames.size)]
        return [frames.mean(), frames.var()], expected, errors

    effect = BlackLevelOffset(offset_e=offset)
    real = frames_of(effect, rate=flat(LIGHT_E))
    tells_apart(figures, real, frames_of(rate=flat(LIGHT_E + offset)))
    dark = frames_of(effect, rate=flat(LIGHT_E), level=0.0)
    assert_agree(dark.mean(), offset, READ_E / math.sqrt(dark.size))


def test_adc_dnl_is_a_comb_of_powers_of_two() -> None:
    """Widths of codes below an equal number of trailing zeros are equal; the ends stay."""
    samples = 256  # per code: an edge is found to one of them
    ramp = (np.arange(256 * samples) + 0.5) / samples - 0.5

    def spread(codes: Array) -> float:
        widths = np.bincount(codes.astype(int).ravel(), minlength=256) / samples
        before = list(range(1, 255))
        zeros = np.array([(c & -c).bit_length() - 1 for c in before])
        groups = [widths[:254][zeros == z] for z in range(7)]
        return float(max(np.ptp(group) for group in groups))

    real = np.round(applied(AdcDnl(unit_mismatch=0.02), ramp.reshape(1, 256, samples)))
    assert real.min() == 0
    assert real.max() == 255
    assert spread(real) <= 2 / samples

    dnl = np.bincount(real.astype(int).ravel(), minlength=256) / samples - 1
    assert dnl.std() > 4 / samples  # there is something to tell apart
    widths = 1 + dnl.std() * np.random.default_rng(1).standard_normal(256)
    impostor = np.searchsorted(np.cumsum(widths)[:-1], ramp + 0.5)
    assert spread(impostor) > 2 / samples


def test_adc_dnl_of_the_major_carry_has_the_stated_spread() -> None:
    rng, mismatch, bodies = np.random.default_rng(2), 0.005, 4000
    middle = []
    for _ in range(bodies):
        begins = weighed(rng.standard_normal(8).astype(np.float32), mismatch)
        assert begins[-1] == pytest.approx(255)
        middle.append(widths(begins)[127] - 1)
    expected = mismatch**2 * 255
    assert_agree(np.var(middle), expected, variance_error(expected, bodies))


def test_thresholds_that_err_by_themselves_borrow_from_the_next_code() -> None:
    """What one code gains its neighbours lose: widths have the correlation -1/2, no comb has."""
    samples, sigma = 512, 0.1
    ramp = (np.arange(256 * samples) + 0.5) / samples - 0.5

    def of_next(effect: AdcDnl) -> tuple[float, float]:
        codes = np.round(applied(effect, ramp.reshape(1, 256, samples))).astype(int).ravel()
        dnl = np.bincount(codes, minlength=256)[1:255] / samples - 1
        return float(dnl.var()), float((dnl[1:] * dnl[:-1]).mean() / dnl.var())

    variance, correlation = of_next(AdcDnl(unit_mismatch=0.0, threshold_sigma_dn=sigma))
    # moments of a moving average of normal numbers: 1.5 and 1 times those of independent ones
    assert_agree(variance, 2 * sigma**2, math.sqrt(1.5) * variance_error(2 * sigma**2, 254))
    assert_agree(correlation, -0.5, 1 / math.sqrt(254))
    _, of_a_comb = of_next(AdcDnl(unit_mismatch=0.02))
    assert abs(of_a_comb + 0.5) > 3 / math.sqrt(254)


def test_bit_truncation_leaves_every_eighth_code() -> None:
    lost = 3

    def figures(frames: Array) -> Figures:
        codes = frames + 500.0
        step = 2**lost
        expected = [1.0, 500.0 + LIGHT_E - (step - 1) / 2, NOISE + ROUNDING + (step**2 - 1) / 12]
        share = math.sqrt(1 / step * (1 - 1 / step) / codes.size)
        errors = [share, math.sqrt(NOISE / codes.size), variance_error(expected[2], codes.size)]
        return [np.mean(codes % step == 0), codes.mean(), codes.var()], expected, errors

    real = frames_of(BitTruncation(bits=lost), rate=flat(LIGHT_E))
    moved = BlackLevelOffset(offset_e=-(2**lost - 1) / 2)
    noisier = independent(math.sqrt((4**lost - 1) / 12))
    tells_apart(figures, real, frames_of(moved, noisier, rate=flat(LIGHT_E)))


def test_halves_of_codes_go_where_they_are_told() -> None:
    """And what is as near to them as an order of additions makes it. Noise of a code spread evenly
    over quarters is then 1/4 (0 + 1/16 + 1/4 + 1/16) = 3/32 whichever way, and the mean is an
    eighth off: half a code for one value in four."""
    nearly = np.array([[[2.5, 3.5, 3.5 - 5e-4, 2.5 + 5e-4, 3.498, 3.502]]])
    assert applied(Quantization(), nearly).ravel().tolist() == [2, 4, 3, 3, 3, 4]
    assert applied(Quantization(halves=1.0), nearly).ravel().tolist() == [3, 4, 4, 3, 3, 4]
    assert applied(Quantization(halves=-1.0), nearly).ravel().tolist() == [2, 3, 3, 2, 3, 4]
    quarters = np.arange(0.0, 64.0, 0.25).reshape(1, 16, 16)
    for way in (1.0, -1.0):
        off = applied(Quantization(halves=way), quarters) - quarters
        assert off.mean() == pytest.approx(way / 8, abs=1e-9)
        assert np.square(off).mean() == pytest.approx(3 / 32, abs=1e-9)
