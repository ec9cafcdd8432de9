"""Processing: what follows from each equation, and that an impostor fails it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage

from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.defect_correction import DefectCorrection
from sensor.effects.demosaic import Demosaic
from sensor.effects.demosaic_other import DemosaicOther
from sensor.effects.gamma import Gamma
from sensor.effects.sharpening import Sharpening
from sensor.effects.temporal_filter import TemporalFilter
from sensor.effects.white_balance import WhiteBalance
from tests.effects_bench import READ_E, Array, flat, frames_of, rate_of
from tests.effects_chain import (
    LIGHT_E,
    NOISE,
    ROUNDING,
    Figures,
    applied,
    by_frame,
    covariances,
    noise_on,
    tells_apart,
)
from tests.harness import variance_error


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


@pytest.mark.parametrize("way", [0.0, 1.0, 2.0])
def test_gamma_begins_at_code_0_or_at_black_with_a_chord_or_without(way: float) -> None:
    """Without a chord what is below black is bent the other way, and a code above it rises by
    R^(1-g); with one, all codes near black rise by 0.018^(g-1)."""
    black, exponent = 5.0, 0.8
    dn = np.array([3.0, 4.9, 5.0, 5.1, 6.0, 90.0, 250.0])
    origin = black if way else 0.0
    x = (dn - origin) / (255.0 - origin)
    curve = np.sign(x) * np.abs(x) ** exponent
    if way == 1.0:
        curve = np.where(x > 0.018, curve, x * 0.018 ** (exponent - 1.0))
    image = np.tile(dn, (1, 4, 1)).astype(np.float32)
    found = applied(Gamma(exponent=exponent, about_black=way), image, black_dn=black)
    assert found[0, 0] == pytest.approx(origin + (255.0 - origin) * curve, abs=2e-3)


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
    mixed = np.array([[1.2, -0.15, -0.05], [0.1, 0.8, 0.1], [-0.02, -0.28, 1.3]])
    effect = ColorMatrix(
        saturation=saturation,
        next_colour=Colours(R=-0.15, G=0.1, B=-0.02),
        last_colour=Colours(R=-0.05, G=0.1, B=-0.28),
    )
    matrix = (saturation * np.eye(3) + (1 - saturation) * np.ones((3, 1)) * weights) @ mixed
    assert effect.matrix == pytest.approx(matrix)
    expected = matrix @ np.diag(sigmas**2) @ matrix.T
    upper = np.triu_indices(3)

    def figures(frames: Array) -> Figures:
        d = frames - 100.0
        products = np.einsum("fyxi,fyxj->fij", d, d) / d[0, ..., 0].size
        mean, error = by_frame(products[:, upper[0], upper[1]])
        return mean, expected[upper], error

    grey = 100.0 + sigmas * np.random.default_rng(3).standard_normal((64, 32, 32, 3))
    impostor = noise_on(0.0, 1.0, 64, 32, 32, 3) * np.sqrt(np.diag(expected)) + 100.0
    tells_apart(figures, applied(effect, grey), impostor)


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


@pytest.mark.parametrize("algorithm", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("cfa", ["RGGB", "BGGR", "GRBG", "GBRG"])
def test_demosaic_other_keeps_the_samples_and_flat_colours(algorithm: int, cfa: str) -> None:
    effect = DemosaicOther(algorithm=algorithm)
    mosaic = noise_on(100.0, 5.0, 2, 24, 32)
    bilinear = applied(Demosaic(), mosaic, cfa=cfa)
    sites = np.array(["RGB".index(c) for c in cfa]).reshape(2, 2)
    sites = np.tile(sites, (12, 16))[None, :, :, None]
    kept = np.take_along_axis(applied(effect, bilinear, cfa=cfa), sites, axis=3)[..., 0]
    # OpenCV takes codes of 16 and 8 bits
    resolution = {3: 0.5 / 256, 4: 0.5, 5: 0.5}.get(algorithm, 0)
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


def test_variable_gradients_do_not_mix_the_greens_of_an_edge() -> None:
    """A grey step along the columns: the directions that cross it vary, and green, which has
    measured neighbours along it, is filled in from one side alone. A mean of equal weights mixes
    three of one side with one of the other."""
    step = np.where(np.arange(32) < 16, 50.0, 150.0)
    bilinear = applied(Demosaic(), np.broadcast_to(step, (1, 24, 32)), cfa="RGGB")
    real = applied(DemosaicOther(algorithm=4), bilinear, cfa="RGGB")
    assert set(np.unique(bilinear[..., 1])) == {50.0, 75.0, 125.0, 150.0}
    assert set(np.unique(real[..., 1])) == {50.0, 150.0}


def test_edge_aware_on_whole_codes_sends_halves_up() -> None:
    """Where nothing has an edge across, each missing red of a row is (a + b + 1) >> 1 of the whole
    codes beside it, and in fractions their mean."""
    columns = np.round(noise_on(100.0, 20.0, 1, 1, 32))
    mosaic = np.broadcast_to(columns, (1, 24, 32))
    bilinear = applied(Demosaic(), mosaic, cfa="RGGB")
    of_codes, of_fractions = (
        applied(DemosaicOther(algorithm=a), bilinear, cfa="RGGB")[0, 8, 8:24, 0] for a in (5, 3)
    )
    beside = (columns[0, 0, 8:-8:2] + columns[0, 0, 10:-6:2]) / 2
    assert np.any(beside % 1 == 0.5)
    assert np.array_equal(of_codes[1::2], np.floor(beside + 0.5))
    assert np.allclose(of_fractions[1::2], beside, atol=1 / 256)


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


@pytest.mark.parametrize("cfa", ["GGGG", "RGGB"])
def test_a_defect_that_is_beyond_all_its_neighbours_is_beyond_a_ramp(cfa: str) -> None:
    """On a ramp of 5 DN a sample a sample lies between its neighbours, the farthest of which are
    one step away: what is 8 DN above is 3 above the highest and 8 above their median. It is put
    back to that median where the threshold is less, and stays otherwise."""
    step = 2 if cfa == "RGGB" else 1
    ramp = np.tile(5.0 * (np.arange(64) // step), (4, 64, 1))
    up = ramp.copy()
    up[:, 16::16, 16::16] += 8.0

    def corrected(threshold_dn: float, beyond_all: float) -> Array:
        effect = DefectCorrection(threshold_dn=threshold_dn, beyond_all=beyond_all)
        inner = (slice(None), slice(8, -8), slice(8, -8))
        return np.asarray(applied(effect, up, cfa=cfa))[inner]

    inner = (slice(None), slice(8, -8), slice(8, -8))
    for threshold_dn, beyond_all, gone in ((2.0, 1.0, True), (4.0, 1.0, False), (7.0, 0.0, True)):
        expected = ramp if gone else up
        assert np.array_equal(corrected(threshold_dn, beyond_all), expected[inner])


def test_a_search_begins_near_any_threshold_of_8_bits() -> None:
    """Which edges go is another matter at each threshold, so no small step leads from one that is
    more than an octave away: 222 DN was seen and not named while the highest start was 96.
    """
    (threshold,) = (p for p in DefectCorrection.parameters() if p.name == "threshold_dn")
    starts = np.array(threshold.starts, dtype=float)
    for codes in range(1, 255):
        assert np.abs(np.log2(codes / starts)).min() <= 1.0
