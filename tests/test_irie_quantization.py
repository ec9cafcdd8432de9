"""The curves of N_Q against Figs. 2 and 3, and the factors N_D against Table V."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from analysis.estimators.parts import quantization
from analysis.estimators.parts.panel_noise import measure_panel
from analysis.estimators.parts.quantization import curve, point_lamp
from analysis.estimators.parts.reading import N_D

SAMPLES = 50 * 50 * 100
"""Samples behind each point of a curve: an SD is known to 1 / sqrt(2 x 250,000)."""

LIMIT = 4.5


def error(kind, gradient, added):
    at = curve(kind, gradient=gradient)
    return float(np.interp(added, at.added_dn, at.error_dn))


@pytest.mark.parametrize("kind", ["temporal", "spatial"])
def test_without_a_gradient_small_noise_is_rounded_away(kind):
    at = curve(kind, gradient=False)
    small = at.added_dn <= 0.1
    assert np.allclose(at.error_dn[small], -at.added_dn[small], atol=1e-3)


@pytest.mark.parametrize("kind", ["temporal", "spatial"])
def test_without_a_gradient_the_error_crosses_zero_near_a_third_of_a_step(kind):
    at = curve(kind, gradient=False)
    above = int(np.argmax(at.error_dn > 0))
    low, high = at.error_dn[above - 1 : above + 1]
    crossing = np.interp(0, [low, high], at.added_dn[above - 1 : above + 1])
    assert crossing == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize(("kind", "height"), [("temporal", 0.07), ("spatial", 0.056)])
def test_without_a_gradient_the_error_peaks_at_half_a_step(kind, height):
    at = curve(kind, gradient=False)
    assert at.added_dn[np.argmax(at.error_dn)] == pytest.approx(0.5, abs=0.05)
    assert at.error_dn.max() == pytest.approx(height, abs=0.004)


def test_the_column_fit_drives_the_spatial_error_negative_near_1_2():
    assert error("spatial", False, 1.0) > 0 > error("spatial", False, 1.3)
    assert error("spatial", False, 5.0) == pytest.approx(5 * (math.sqrt(47 / 50) - 1), abs=0.01)


def test_a_gradient_alone_is_measured_as_the_noise_of_rounding():
    assert error("spatial", True, 0.0) == pytest.approx(0.286, abs=0.003)


def test_with_a_gradient_noise_in_time_is_over_estimated():
    at = curve("temporal", gradient=True)
    inside = (at.added_dn > 0) & (at.added_dn < 3.5)
    assert np.all(at.error_dn[inside] > 0)
    assert at.error_dn[0] == 0
    # Beyond, what is left is rounding less the bias of the SD of 100 frames.
    bias = math.sqrt(2 / 99) * math.exp(math.lgamma(50) - math.lgamma(49.5))
    end = bias * math.sqrt(25 + 1 / 12) - 5
    assert abs(at.error_dn[-1] - end) < LIMIT * 5 / math.sqrt(2 * SAMPLES)


@pytest.mark.parametrize("kind", ["temporal", "spatial"])
def test_beyond_half_a_step_both_figures_agree(kind):
    plain, lit = curve(kind, gradient=False), curve(kind, gradient=True)
    beyond = plain.added_dn >= 0.6
    assert np.allclose(plain.error_dn[beyond], lit.error_dn[beyond], atol=0.005)


@pytest.mark.parametrize("slope", [0.1, 0.2, 0.3])
def test_any_gradient_that_sweeps_a_few_codes_gives_the_same_curve(slope):
    at = curve("spatial", gradient=True, slope_dn_per_px=slope)
    ours = curve("spatial", gradient=True)
    assert np.allclose(at.error_dn, ours.error_dn, atol=0.006)


def test_the_lamp_falls_off_with_the_square_of_its_distance():
    level = point_lamp(51, 51, 0.2)
    assert level[25, 25] == pytest.approx(quantization.LEVEL_DN)
    slope = np.hypot((level[26, 25] - level[24, 25]) / 2, (level[25, 26] - level[25, 24]) / 2)
    assert slope == pytest.approx(0.2, rel=1e-3)
    distance = 1 / np.sqrt(level)
    assert np.allclose(np.diff(distance, 2, axis=0), 0, atol=1e-12)


@pytest.mark.parametrize("kind", ["temporal", "spatial"])
@pytest.mark.parametrize("gradient", [False, True])
def test_taking_the_error_off_gives_back_the_added_noise(kind, gradient):
    at = curve(kind, gradient=gradient)
    for added, measured in zip(at.added_dn, at.measured_dn, strict=True):
        if added < 0.25:  # where rounding hides it, several added noises look the same
            continue
        assert at.noise_before(float(measured))[0] == pytest.approx(added, abs=1e-9)
    before, slope = at.noise_before(12.0)
    assert before / 12 == pytest.approx(5 / at.measured_dn[-1])
    assert slope == pytest.approx(before / 12)
    assert at.noise_before(at.floor_dn) == (0.0, 0.0)


def test_short_stacks_and_low_panels_have_their_own_curves():
    two = curve("temporal", gradient=False, frames=2).noise_before(4.0)[0]
    assert two == pytest.approx(4 * math.sqrt(math.pi / 2), rel=0.01)
    low = curve("spatial", gradient=False, rows=10).noise_before(4.0)[0]
    assert low == pytest.approx(4 / math.sqrt(0.7), rel=0.01)


def test_curves_are_the_same_every_time_and_quick():
    quantization._curves.cache_clear()
    start = time.perf_counter()
    first = curve("temporal", gradient=False).measured_dn
    assert time.perf_counter() - start < 3  # a third of a second where nothing else runs
    quantization._curves.cache_clear()
    assert np.array_equal(first, curve("temporal", gradient=False).measured_dn)


def bilinear(raw: np.ndarray, sites: list[tuple[int, int]]) -> np.ndarray:
    """One colour of a mosaic by bilinear interpolation, on a periodic image."""
    x = np.zeros_like(raw)
    for i, j in sites:
        x[..., i::2, j::2] = raw[..., i::2, j::2]
    near = sum(np.roll(x, k, axis) for k in (-1, 1) for axis in (-2, -1))
    if len(sites) == 2:
        return x + near / 4
    corners = sum(np.roll(x, (i, j), (-2, -1)) for i in (-1, 1) for j in (-1, 1))
    return x + near / 2 + corners / 4


@pytest.mark.parametrize(
    ("channel", "sites", "in_time"),
    [
        ("R", [(0, 0)], (1 + math.sqrt(2) + 0.5) / 4),
        ("G", [(0, 1), (1, 0)], 0.75),
        ("B", [(1, 1)], (1 + math.sqrt(2) + 0.5) / 4),
    ],
)
def test_bilinear_demosaic_attenuates_as_in_table_v(channel, sites, in_time):
    """Against noise that went through the same measure; steps of rounding are made tiny."""
    raw = np.random.default_rng(20).normal(30_000, 1000, (100, 50, 50))
    before = measure_panel(np.rint(raw).astype(np.uint16), 65535)
    after = measure_panel(np.rint(bilinear(raw, sites)).astype(np.uint16), 65535)
    temporal = after.temporal_dn / before.temporal_dn
    spatial = after.columns_dn / before.columns_dn
    assert temporal == pytest.approx(in_time, abs=0.004)
    assert temporal == pytest.approx(N_D["temporal"][channel], abs=0.006)
    assert spatial == pytest.approx(N_D["spatial"][channel], abs=0.006)
    # Against the raw noise itself the same panel gives what is left of it beyond the fit.
    raw_ratio = {"R": 0.691, "G": 0.748, "B": 0.691}[channel]
    assert after.columns_dn / 1000 == pytest.approx(raw_ratio, abs=0.006)
