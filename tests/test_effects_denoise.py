"""A noise filter in space: what follows from its equation, and that an impostor fails it."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from scipy import ndimage

from sensor.effects.spatial_denoise import SpatialDenoise
from tests.effects_bench import Array
from tests.effects_chain import Figures, applied, by_frame, noise_on, tells_apart


@pytest.mark.parametrize("diagonal", [1.0, 0.25])
def test_spatial_denoise_keeps_an_edge_that_a_blur_softens(diagonal: float) -> None:
    sigma, step, strength = 2.0, 60.0, 1.0
    window = 5 + 4 * diagonal
    left = (1 - strength * (window - 1) / window) ** 2
    left += 4 * (1 + diagonal**2) * (strength / window) ** 2

    def figures(frames: Array) -> Figures:
        edge = frames[:, :, 32] - frames[:, :, 31]
        variance = frames[:, 4:-4, 4:-36].var((1, 2), ddof=0)
        mean, error = by_frame(np.stack([edge.mean(1), variance], axis=1))
        # a blur that keeps the mean leaves the variance of a mean as it was: the sample's own takes
        # sigma^2 over its pixels off
        return mean, [step, sigma**2 * (left - 1 / (56 * 24))], error

    before = noise_on(50.0, sigma, 128, 64, 64)
    before[:, :, 32:] += step
    effect = SpatialDenoise(strength=strength, threshold_dn=30.0, diagonal=diagonal)
    box = ndimage.uniform_filter(before, (1, 3, 3), mode="mirror")
    tells_apart(figures, applied(effect, before), box)


@pytest.mark.parametrize(("window", "last"), [(1, 2), (2, 4), (3, 8)])
def test_a_round_window_of_spatial_denoise_is_a_normal_distribution(window: int, last: int) -> None:
    """Weights exp(-r^2 / 2 sigma^2) about a pixel, normalised, for s = w (1 + sum of w_j) over the
    sum of all of them; by another program's filter."""
    variance = 0.81
    square = np.add.outer(np.arange(-2, 3) ** 2, np.arange(-2, 3) ** 2)
    weights = np.where(square <= last, np.exp(-square / (2 * variance)), 0.0)
    diagonal = math.exp(-1 / (2 * variance))
    alike = 1 + ((weights.sum() - 1) / diagonal)
    before = noise_on(100.0, 5.0, 2, 32, 32, 3)
    effect = SpatialDenoise(
        strength=diagonal * alike / weights.sum(),
        threshold_dn=1e3,
        diagonal=diagonal,
        window=float(window),
    )
    soft = ndimage.correlate(before, (weights / weights.sum())[None, :, :, None], mode="mirror")
    assert np.allclose(applied(effect, before), soft, atol=1e-3)


@pytest.mark.parametrize("threshold_dn", [3.0, 10.0, 30.0])
@pytest.mark.parametrize("colours", [True, False])
def test_a_soft_spatial_denoise_is_the_bilateral_filter(threshold_dn: float, colours: bool) -> None:
    """That of OpenCV, which adds up what colours differ by, on noise and an edge."""
    before = noise_on(100.0, 5.0, 2, 32, 32, 3).astype(np.float32)
    before[:, :, 16:] += 20.0
    if not colours:
        before = before[..., 0]
    effect = SpatialDenoise(
        strength=1.0,
        threshold_dn=threshold_dn,
        diagonal=math.exp(-1 / (2 * 1.2**2)),
        window=2.0,
        soft=2.0 if colours else 1.0,
    )
    theirs = [
        cv2.bilateralFilter(
            np.ascontiguousarray(one), 5, threshold_dn, 1.2, borderType=cv2.BORDER_REFLECT_101
        )
        for one in before
    ]
    assert np.allclose(applied(effect, before), theirs, atol=1e-3)


@pytest.mark.parametrize("threshold_dn", [1.0, 3.0, 10.0])
@pytest.mark.parametrize("coloured", [True, False])
def test_a_spatial_denoise_by_patches_is_the_mean_of_those_alike(
    threshold_dn: float, coloured: bool
) -> None:
    """Non-local means by its definition: weights exp(-d^2 / 2 T^2), d^2 the mean square of what the
    3 x 3 pixels about both differ by, over all 5 x 5; on noise and an edge."""
    before = noise_on(100.0, 2.0, 2, 32, 40, 3)
    before[:, :, 20:] += 20.0
    if not coloured:
        before = before[..., 0]
    effect = SpatialDenoise(
        strength=1.0, threshold_dn=threshold_dn, diagonal=1.0, window=3.0, soft=3.0
    )
    patch = (1, 3, 3, 1)[: before.ndim]
    total, count = np.zeros((2, *before.shape))
    for dy in range(-2, 3):
        for dx in range(-2, 3):
            theirs = np.roll(before, (-dy, -dx), axis=(1, 2))
            unlike = ndimage.uniform_filter(np.square(theirs - before), patch)
            weight = np.exp(-unlike / (2 * threshold_dn**2))
            total += weight * theirs
            count += weight
    inside = np.s_[:, 4:-4, 4:-4]
    found = applied(effect, before)
    assert np.allclose(found[inside], (total / count)[inside], atol=1e-3)
