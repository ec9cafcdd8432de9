"""Effects from readout to cable: what follows from each equation, and that an impostor fails it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import ndimage
from scipy.fft import dctn

from foundation.backend import backend
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.adc_dnl import AdcDnl, weighed, widths
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.black_level_drift import BlackLevelDrift
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.chroma_subsampling import ChromaSubsampling
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.column_fpn import ColumnFpn
from sensor.effects.defect_correction import DefectCorrection
from sensor.effects.demosaic import Demosaic
from sensor.effects.demosaic_other import DemosaicOther
from sensor.effects.dropped_frames import DroppedFrames
from sensor.effects.flicker_noise import FlickerNoise
from sensor.effects.fpn import Fpn
from sensor.effects.gamma import Gamma
from sensor.effects.interference import Interference
from sensor.effects.jpeg import Jpeg
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.effects.row_noise import RowNoise
from sensor.effects.sharpening import Sharpening
from sensor.effects.spatial_denoise import SpatialDenoise
from sensor.effects.temporal_filter import TemporalFilter
from sensor.effects.white_balance import WhiteBalance
from sensor.errors import CameraError
from sensor.protocol import Shot
from sensor.signal import Format, Quantity, Signal
from sensor.simulation import simulate, stream_of
from tests.effects_bench import READ_E, Array, flat, frames_of, rate_of
from tests.harness import assert_agree, variance_error, worst_z

LIGHT_E = 400.0
NOISE = LIGHT_E + READ_E**2
"""Temporal variance of the bench in e-^2 at LIGHT_E, before rounding."""

ROUNDING = 1 / 12

Figures = tuple[Any, Any, Any]
"""Measured, expected, standard errors."""


def tells_apart(figures: Callable[[Array], Figures], real: Array, impostor: Array) -> None:
    """The effect has its closed form; its impostor has not."""
    assert_agree(*figures(real), "the effect")
    worst, limit = worst_z(*figures(impostor))
    assert worst > limit, f"the impostor passes: {worst:.2f} standard errors of {limit:.2f}"


def by_frame(statistics: Array) -> tuple[Array, Array]:
    """Mean of figures taken frame by frame, (F, n), and its standard error."""
    error = statistics.std(0, ddof=1) / math.sqrt(len(statistics))
    return statistics.mean(0), error


def independent(sigma: float) -> ReadNoise:
    """Independent noise of that standard deviation on top of the bench's own."""
    return ReadNoise(reset_e=0.0, thermal_e=READ_E, other_e=sigma)


def applied(effect: Effect, values: Array, *, cfa: str = "GGGG", bits: int = 8) -> Array:
    """The effect alone on given DN, frame by frame."""
    camera = Camera(
        name="bare", height=values.shape[1], width=values.shape[2], pixels="bayer16", bits=16,
        gain_dn_per_e=Colours.of(1.0),
    )  # fmt: skip
    shot = Shot(label="bare", exposure_s=0.01, frames=len(values))
    where, frames = backend(), range(len(values))
    form = Format(
        height=values.shape[1], width=values.shape[2], cfa=cfa, bits=bits,
        gain_dn_per_e=camera.gain_dn_per_e, black_dn=0.0,
    )  # fmt: skip
    signal = Signal(
        numbers=where.tensor(values), quantity=effect.quantity(), format=form, shot=shot,
        frames=frames, backend=where,
    )  # fmt: skip
    stream = stream_of(camera, effect, shot, 1, frames, where)
    return effect.apply(signal, stream).numpy().astype(np.float64)


def noise_on(level: float, sigma: float, *shape: int, seed: int = 5) -> Array:
    return level + sigma * np.random.default_rng(seed).standard_normal(shape)


def covariances(frames: Array, mean: float, lags: list[tuple[int, int]]) -> Array:
    """Covariance at lags (dy, dx) of every frame about a known mean, (F, lags); no borders."""
    d = frames[:, 3:-3, 3:-3] - mean
    height, width = d.shape[1:]
    return np.stack(
        [
            (d[:, : height - dy, : width - dx] * d[:, dy:, dx:]).mean((1, 2))
            for dy, dx in lags
        ],
        axis=1,
    )  # fmt: skip


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


def test_flicker_noise_has_equal_power_in_every_octave() -> None:
    sigma, height, width = 60.0, 64, 128
    octaves = int(math.log2(height * width))
    white = 1 / math.log(2)
    edges = 0.5 / 2.0 ** np.arange(9)[::-1]

    def spectrum(f: Array) -> Array:
        """Of the sum of holds, plus the bench's read noise: two-sided, per pixel."""
        holds = sum(
            np.sin(np.pi * f * 2**j) ** 2 / (2**j * np.sin(np.pi * f) ** 2)
            for j in range(1, octaves)
        )
        return sigma**2 / (octaves - 1 + white) * (white + holds) + READ_E**2 + ROUNDING

    def figures(frames: Array) -> Figures:
        series = frames.reshape(len(frames), -1)
        n = series.shape[1]
        window = np.hanning(n) * math.sqrt(8 / 3)
        power = np.abs(np.fft.rfft(series * window)) ** 2 / n
        f = np.fft.rfftfreq(n)
        bands = [(f > low) & (f <= high) for low, high in itertools.pairwise(edges)]
        measured, error = by_frame(np.stack([power[:, band].mean(1) for band in bands], axis=1))
        return measured, [spectrum(f[band]).mean() for band in bands], error

    rate = flat(0.0, height, width)
    real = frames_of(FlickerNoise(sigma_e=sigma), rate=rate, frames=128)
    tells_apart(figures, real, frames_of(independent(sigma), rate=rate, frames=128))

    measured, _, error = figures(real)
    octave = np.log(edges[1:])
    slope = np.polyfit(octave, np.log(measured - READ_E**2 - ROUNDING), 1)[0]
    leverage = (octave - octave.mean()) / np.sum((octave - octave.mean()) ** 2)
    slope_error = np.sqrt(np.sum((leverage * error / measured) ** 2))
    ripple = 0.14 * np.abs(leverage).max()  # one band, at the end of the fit, that is off by 14 %
    assert abs(slope + 1) < ripple + 4 * slope_error


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


def test_gamma_passes_noise_with_the_slope_of_the_curve() -> None:
    exponent, levels, span = 0.8, np.array([4000.0, 30000.0]), 65535 - 500.0
    slope = exponent * (levels / span) ** (exponent - 1)

    def figures(frames: Array) -> Figures:
        before = levels + READ_E**2
        bend = exponent * (exponent - 1) * (levels / span) ** (exponent - 2) / span
        means = span * (levels / span) ** exponent + bend * before / 2
        after = slope**2 * before
        n = frames[0].size
        measured = [*frames.mean((1, 2, 3)), *frames.var((1, 2, 3))]
        errors = [*np.sqrt(after / n), *variance_error(after, n)]
        return measured, [*means, *(after + ROUNDING)], errors

    def at_levels(*effects: Effect) -> Array:
        return np.stack([frames_of(*effects, rate=flat(level)) for level in levels])

    # a gain and an offset that do the same to mean and variance at the lower level
    straight = span * (levels[0] / span) ** exponent + slope[0] * (at_levels() - levels[0])
    tells_apart(figures, at_levels(Gamma(exponent=exponent)), straight)


def test_white_balance_multiplies_the_conversion_where_light_does_not() -> None:
    gains = np.array([1.5, 1.0, 2.0])

    def figures(frames: Array) -> Figures:
        samples = [frames[:, 0::2, 0::2], frames[:, 0::2, 1::2], frames[:, 1::2, 1::2]]
        measured = [*(s.mean() for s in samples), *(s.var() for s in samples)]
        variances = gains**2 * NOISE + ROUNDING
        n = samples[0].size
        errors = [*np.sqrt(variances / n), *variance_error(variances, n)]
        return measured, [*(gains * LIGHT_E), *variances], errors

    effect = WhiteBalance(red_gain=gains[0], blue_gain=gains[2])
    real = frames_of(effect, rate=flat(LIGHT_E), cfa="RGGB")
    brighter = frames_of(rate=rate_of(np.full((64, 96, 3), LIGHT_E) * gains), cfa="RGGB")
    tells_apart(figures, real, brighter)


def test_color_matrix_correlates_the_noise_of_the_channels() -> None:
    saturation, weights = 1.6, np.array([0.299, 0.587, 0.114])
    sigmas = np.array([3.0, 2.0, 4.0])
    matrix = saturation * np.eye(3) + (1 - saturation) * np.ones((3, 1)) * weights
    expected = matrix @ np.diag(sigmas**2) @ matrix.T
    upper = np.triu_indices(3)

    def figures(frames: Array) -> Figures:
        d = frames - 100.0
        products = np.einsum("fyxi,fyxj->fij", d, d) / d[0, ..., 0].size
        mean, error = by_frame(products[:, upper[0], upper[1]])
        return mean, expected[upper], error

    grey = 100.0 + sigmas * np.random.default_rng(3).standard_normal((64, 32, 32, 3))
    impostor = noise_on(0.0, 1.0, 64, 32, 32, 3) * np.sqrt(np.diag(expected)) + 100.0
    tells_apart(figures, applied(ColorMatrix(saturation=saturation), grey), impostor)


def test_sharpening_makes_neighbours_disagree() -> None:
    amount, sigma = 1.0, 10.0
    soft = np.outer([1, 2, 1], [1, 2, 1]) / 16
    kernel = -amount * soft
    kernel[1, 1] += 1 + amount
    lags = [(0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (0, 3)]
    padded = np.pad(kernel, 3)
    expected = [sigma**2 * np.sum(padded * np.roll(padded, lag, (0, 1))) for lag in lags]
    assert expected[0] == pytest.approx(sigma**2 * (1 + 1.5 * amount + 41 / 64 * amount**2))

    def figures(frames: Array) -> Figures:
        measured, error = by_frame(covariances(frames, 100.0, lags))
        return measured, expected, error

    before = noise_on(100.0, sigma, 64, 64, 64)
    impostor = noise_on(100.0, math.sqrt(expected[0]), 64, 64, 64, seed=6)
    tells_apart(figures, applied(Sharpening(amount=amount), before), impostor)
    # on an image with colours it sharpens luma: grey detail alike, and colour differences stay
    colours = noise_on(100.0, sigma, 2, 32, 32, 3)
    change = applied(Sharpening(amount=amount), colours) - colours
    assert np.ptp(change, axis=3).max() < 1e-4
    assert change.std() > 1


@pytest.mark.parametrize("passes", [1, 2, 3])
@pytest.mark.parametrize("each_colour", [0, 1])
def test_a_wider_sharpening_lacks_what_so_many_passes_soften(passes: int, each_colour: int) -> None:
    """a (x - x * B^n), of luma for all colours or of each colour; by another program's filter."""
    before = noise_on(100.0, 10.0, 2, 32, 32, 3)
    source = before if each_colour else (before @ [0.299, 0.587, 0.114])[..., None]
    soft = source
    for _ in range(passes):
        for axis in (1, 2):
            soft = ndimage.correlate1d(soft, [0.25, 0.5, 0.25], axis=axis, mode="mirror")
    sharp = Sharpening(amount=0.7, passes=float(passes), each_colour=float(each_colour))
    assert np.allclose(applied(sharp, before), before + 0.7 * (source - soft), atol=1e-3)


def test_spatial_denoise_keeps_an_edge_that_a_blur_softens() -> None:
    sigma, step, strength = 2.0, 60.0, 1.0
    left = (1 - 8 * strength / 9) ** 2 + 8 * (strength / 9) ** 2

    def figures(frames: Array) -> Figures:
        edge = frames[:, :, 32] - frames[:, :, 31]
        variance = frames[:, 4:-4, 4:-36].var((1, 2), ddof=0)
        mean, error = by_frame(np.stack([edge.mean(1), variance], axis=1))
        cells = 56 * 24 / 9  # independent means of nine pixels: what a sample's own mean takes off
        return mean, [step, sigma**2 * left * (1 - 1 / cells)], error

    before = noise_on(50.0, sigma, 128, 64, 64)
    before[:, :, 32:] += step
    effect = SpatialDenoise(strength=strength, threshold_dn=30.0)
    box = ndimage.uniform_filter(before, (1, 3, 3), mode="mirror")
    tells_apart(figures, applied(effect, before), box)


def test_temporal_filter_remembers_in_the_dark_and_pixel_by_pixel() -> None:
    carried, lags = 0.5, [0, 1, 2, 4]

    def figures(frames: Array) -> Figures:
        d = frames.reshape(len(frames), -1)
        products = np.stack([(d[: len(d) - k] * d[k:]).mean(0) for k in lags], axis=1)
        measured, error = by_frame(products)
        power = READ_E**2 * (1 - carried) / (1 + carried)
        expected = power * carried ** np.array(lags)
        expected[0] += ROUNDING
        return measured, expected, error

    rate = flat(LIGHT_E)
    real = frames_of(TemporalFilter(carried=carried), rate=rate, level=0.0)
    plain = frames_of(rate=rate, level=0.0)
    blurred = ndimage.gaussian_filter(plain, (0, 0.53, 0.53))
    assert blurred.var() == pytest.approx(real.var(), rel=0.1)
    tells_apart(figures, real, blurred)


@pytest.mark.parametrize("algorithm", [1, 2, 3])
@pytest.mark.parametrize("cfa", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_demosaic_other_keeps_the_samples_and_flat_colours(algorithm: int, cfa: str) -> None:
    effect = DemosaicOther(algorithm=algorithm)
    mosaic = noise_on(100.0, 5.0, 2, 24, 32)
    bilinear = applied(Demosaic(), mosaic, cfa=cfa)
    sites = np.array(["RGB".index(c) for c in cfa]).reshape(2, 2)
    sites = np.tile(sites, (12, 16))[None, :, :, None]
    kept = np.take_along_axis(applied(effect, bilinear, cfa=cfa), sites, axis=3)[..., 0]
    resolution = 0.5 / 256 if algorithm == 3 else 0  # OpenCV takes codes of 16 bits
    assert np.abs(kept - mosaic).max() <= resolution + 1e-4
    colours = np.broadcast_to([120.0, 100.0, 60.0], (1, 24, 32, 3))
    assert np.abs(applied(effect, colours, cfa=cfa) - colours).max() < 0.01


def test_demosaic_other_moves_noise_between_the_colours() -> None:
    sigma = 5.0
    expected = sigma**2 * np.array([1 / 4 + 5 / 16, 1 / 2])

    def figures(frames: Array) -> Figures:
        d = frames[:, 4:-4:2, 4:-4:2] - 100.0
        products = [(d[..., 1] ** 2).mean((1, 2)), (d[..., 0] * d[..., 1]).mean((1, 2))]
        measured, error = by_frame(np.stack(products, axis=1))
        return measured, expected, error

    bilinear = applied(Demosaic(), noise_on(100.0, sigma, 64, 48, 48), cfa="RGGB")
    real = applied(DemosaicOther(algorithm=1), bilinear, cfa="RGGB")
    impostor = bilinear.copy()  # green as noisy as Malvar's, by noise of its own
    impostor[..., 1] += noise_on(0.0, sigma * math.sqrt(5 / 16), *bilinear.shape[:3], seed=8)
    tells_apart(figures, real, impostor)


@pytest.mark.parametrize("cfa", ["GGGG", "RGGB"])
def test_defect_correction_takes_an_outlier_away_whole_or_not_at_all(cfa: str) -> None:
    sigma = 2.0

    def figures(frames: Array) -> Figures:
        hot, warm = frames[:, 4::8, 4::8], frames[:, 4::8, 8::8]
        n = hot.size
        errors = [sigma / math.sqrt(n), sigma / math.sqrt(warm.size)]
        return [hot.mean(), warm.mean()], [50.0, 60.0], errors

    before = noise_on(50.0, sigma, 16, 64, 64)
    untouched = applied(DefectCorrection(threshold_dn=22.0), before, cfa=cfa)
    assert np.array_equal(untouched, before.astype(np.float32))
    before[:, 4::8, 4::8] += 90.0
    before[:, 4::8, 8::8] += 10.0
    real = applied(DefectCorrection(threshold_dn=22.0), before, cfa=cfa)
    tells_apart(figures, real, ndimage.gaussian_filter(before, (0, 1.0, 1.0)))


@pytest.mark.parametrize(("mode", "group"), [(1, 2), (2, 4)])
def test_chroma_subsampling_shares_colour_in_groups(mode: int, group: int) -> None:
    sigma = 12.0

    def figures(frames: Array) -> Figures:
        chroma = (frames[..., 2] - frames[..., 0]).reshape(len(frames), 32, -1, group)
        inside = np.mean(chroma.max(3) > chroma.min(3))
        variance = (chroma[..., 0] ** 2).mean((1, 2))
        mean, error = by_frame(variance[:, None])
        # U and V are rounded, and so is what each adds to luma
        rounding = (1.772**2 + 1.402**2 + 2) / 12
        expected = 2 * (sigma**2 + ROUNDING) / group + rounding
        share = 1 / math.sqrt(chroma[..., 0].size)
        return [inside, mean[0]], [0.0, expected], [share, error[0]]

    before = np.round(noise_on(128.0, sigma, 64, 32, 64, 3))
    real = applied(ChromaSubsampling(mode=mode), before)
    assert np.array_equal(real, np.clip(np.round(real), 0, 255))
    difference = ndimage.uniform_filter1d(before[..., 2] - before[..., 0], group, axis=2)
    impostor = before.copy()
    impostor[..., 2] = np.round(before[..., 0] + difference)
    tells_apart(figures, real, impostor)
    luma = np.array([0.299, 0.587, 0.114])
    # luma is rounded once, and once in every colour
    error = np.abs(real @ luma - before @ luma)
    assert error.max() <= 1.0 + 1e-4


def test_colour_in_fractions_leaves_luma_to_the_last_rounding() -> None:
    """Only what goes out is rounded; whole codes on the way round luma once more."""

    def spread(effect: ChromaSubsampling) -> float:
        luma = np.array([0.299, 0.587, 0.114])
        return float((applied(effect, before) @ luma - before @ luma).var())

    # not whole codes: colours would be rounded alike
    before = noise_on(128.0, 12.0, 16, 32, 64, 3)
    expected = (0.299**2 + 0.587**2 + 0.114**2) / 12
    error = variance_error(expected, before[..., 0].size)
    assert_agree(spread(ChromaSubsampling(mode=1, whole_codes=0)), expected, error)
    assert spread(ChromaSubsampling(mode=1)) > 2 * expected


def test_jpeg_puts_the_coefficients_of_its_blocks_on_combs() -> None:
    quality, row = 75, np.array([24, 40, 51, 61])
    steps = (row * (200 - 2 * quality) + 50) // 100  # table K.1, u = 4 to 7 of v = 0, as scaled

    def figures(frames: Array) -> Figures:
        blocks = frames.reshape(len(frames), 8, 8, 8, 8).transpose(0, 1, 3, 2, 4)
        c = dctn(blocks - 128.0, axes=(3, 4), norm="ortho")[..., 0, 4:]
        off = c - steps * np.round(c / steps)
        measured, error = by_frame((off**2).mean((1, 2)))
        # pixels are rounded to whole codes, which an orthonormal transform keeps
        return measured, np.full(4, ROUNDING), error

    before = np.round(noise_on(128.0, 12.0, 64, 64, 64))
    real = applied(Jpeg(quality=quality), before)
    assert len(np.unique(real)) > 20
    tells_apart(figures, real, np.round(ndimage.gaussian_filter(before, (0, 0.6, 0.6))))


@pytest.mark.parametrize(
    ("subsampling", "columns_stay", "rows_stay"),
    [(0.0, True, True), (1.0, False, True), (2.0, False, False)],
)
def test_jpeg_carries_colours_at_the_resolution_that_it_says(
    subsampling: float, columns_stay: bool, rows_stay: bool
) -> None:
    """Red and blue of opposite signs from line to line have little luminance: they are there after
    full resolution, to steps of chroma at quality 95, and gone after half of it."""
    sign = np.where(np.arange(64) % 2, 20.0, -20.0)
    for lines, stay in ((sign[None, :], columns_stay), (sign[:, None], rows_stay)):
        change = np.broadcast_to(lines, (1, 64, 64))
        before = np.stack([128 + change, 128 - 0.4 * change, 128 + change], axis=-1)
        after = applied(Jpeg(quality=95, subsampling=subsampling), before)
        kept = float(((after[..., 0] - after[..., 1]) * np.sign(change)).mean()) / (1.4 * 20)
        assert kept == pytest.approx(1.0 if stay else 0.0, abs=0.15)


def test_dropped_frames_repeat_exactly() -> None:
    probability, count = 0.3, 1500

    def figures(frames: Array) -> Figures:
        same = (frames[1:] == frames[:-1]).all((1, 2))
        pairs = same[1:] & same[:-1]
        # neighbouring pairs overlap: var of their sum is n (p2 + 2 p3 - 3 p4)
        p2, p3, p4 = probability**2, probability**3, probability**4
        errors = np.sqrt([probability - p2, p2 + 2 * p3 - 3 * p4]) / math.sqrt(count)
        return [same.mean(), pairs.mean()], [probability, p2], errors

    rate = flat(LIGHT_E, 8, 8)
    real = frames_of(DroppedFrames(probability=probability), rate=rate, frames=count)
    impostor = frames_of(TemporalFilter(carried=probability), rate=rate, frames=count)
    tells_apart(figures, real, impostor)


def test_effects_that_need_colours_say_so() -> None:
    grey = noise_on(50.0, 1.0, 2, 16, 16)
    for effect in (ColorMatrix(), ChromaSubsampling(), DemosaicOther(), WhiteBalance()):
        with pytest.raises(CameraError, match=effect.name):
            applied(effect, grey)
    for effect in (Sharpening(), Jpeg()):
        with pytest.raises(CameraError, match="mosaic"):
            applied(effect, grey, cfa="RGGB")


@pytest.mark.parametrize("value", [0.5, 1.5])
def test_choices_are_whole_numbers(value: float) -> None:
    with pytest.raises(CameraError, match="expected a whole number from 0 to 3"):
        DemosaicOther(algorithm=value)


def test_a_camera_with_them_gives_whole_codes_in_range() -> None:
    """Transport effects behind the rounding, in an rgb8 camera whose signal clips at both ends."""
    camera = Camera(
        name="clipping", height=32, width=48, gain_dn_per_e=Colours.of(0.3), black_dn=0.0,
        effects=(),
    ).plus(
        ReadNoise(thermal_e=40), Demosaic(), Quantization(), ChromaSubsampling(), Jpeg(quality=60)
    )  # fmt: skip
    rate = np.linspace(0, 1e5, 32 * 48 * 3).reshape(32, 48, 3).astype(np.float32)
    shot = Shot(label="ramp", light=("lamp",), exposure_s=0.01, frames=2)
    codes = simulate(camera, shot, {"lamp": rate}, until=Quantity.CODE).numpy()
    assert np.array_equal(codes, np.clip(np.round(codes), 0, 255))
    assert codes.max() == 255
