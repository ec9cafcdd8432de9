"""A filter in space is told by how measured samples of the noise agree with each other."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from analysis.gap.look.agreeing import beyond_the_next, correlations, green_is_averaged
from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.spatial_denoise import WIDE, WIDE_PLAIN, power_left, weights_of
from tests.mosaic import MOSAIC, filled_in, lit

SIGMA_DN = 8.0
FRAMES, HEIGHT, WIDTH = 16, 144, 144
GREY = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)


def window(a: float, b: float) -> np.ndarray:
    """Three by three weights of one sum."""
    return np.array([[b, a, b], [a, 1 - 4 * a - 4 * b, a], [b, a, b]])


@pytest.mark.parametrize(("a", "b"), [(0.08, 0.06), (0.05, 0.0), (0.03, 0.01)])
@pytest.mark.parametrize("coloured", [True, False])
def test_weights_and_the_noise_that_they_leave(a: float, b: float, coloured: bool) -> None:
    """White noise behind a window of known weights. A correlation of n independent samples has the
    error 1 / sqrt(n), and of samples that share some noise less than twice that; a weight has no
    larger one, because the slope of the correlation over it is 1 or more. At 5 standard errors for
    the 36 figures here, noise along with them (its relative error is sqrt(2 / n))."""
    rng = np.random.default_rng(17)
    raw = 120 + SIGMA_DN * rng.standard_normal((FRAMES, HEIGHT, WIDTH))
    if coloured:
        smooth = ndimage.convolve(filled_in(raw), window(a, b)[None, :, :, None], mode="mirror")
        stack, lattices = lit(smooth, "rgb8"), MOSAIC
    else:
        smooth = ndimage.convolve(raw, window(a, b)[None], mode="mirror")
        stack, lattices = lit(smooth, "mono8"), GREY
    right, down, diagonal = correlations(stack, lattices)
    found = weights_of((right + down) / 2, diagonal, coloured)
    samples = FRAMES * (HEIGHT - 16) * (WIDTH - 16) / (2 if coloured else 1)
    assert found == pytest.approx((a, b), abs=5 * 2 / np.sqrt(samples))
    for lattice in lattices:
        values = lattice.of(stack.dn).astype(float)
        power = values.var(axis=0, ddof=1).mean() - 1 / 12
        channel = lattice.channel if coloured else ""
        expected = SIGMA_DN**2 * power_left(a, b, channel)
        assert power == pytest.approx(expected, rel=5 * 2 * np.sqrt(2 / values.size))


@pytest.mark.parametrize("side", [3, 5])
@pytest.mark.parametrize("coloured", [True, False])
def test_a_window_of_five_is_told_from_one_of_three(side: int, coloured: bool) -> None:
    """Equal weights of n pixels in a row have (n - 2) / n in common two samples on; of a mosaic
    those of three have 1/18. Four standard errors are 0.03: samples share much of their noise."""
    rng = np.random.default_rng(20)
    raw = 120 + SIGMA_DN * rng.standard_normal((FRAMES, HEIGHT, WIDTH))
    weights = np.full((side, side), 1 / side**2)
    if coloured:
        smooth = ndimage.convolve(filled_in(raw), weights[None, :, :, None], mode="mirror")
        further = beyond_the_next(lit(smooth, "rgb8"), MOSAIC)
        assert (further > WIDE) is (side == 5)
    else:
        smooth = ndimage.convolve(raw, weights[None], mode="mirror")
        further = beyond_the_next(lit(smooth, "mono8"), GREY)
        assert (further > WIDE_PLAIN) is (side == 5)
    if side == 3 or not coloured:
        assert further == pytest.approx(1 / 18 if coloured else (side - 2) / side, abs=0.03)


@pytest.mark.parametrize("wander_dn", [0.0, 2 * SIGMA_DN])
def test_noise_of_single_samples_has_no_weights(wander_dn: float) -> None:
    """Three correlations of white noise, at 4.5 standard errors, and of what comes after the next
    one, whether whole frames wander or not: a black level that does was taken for a filter."""
    rng = np.random.default_rng(18)
    raw = 120 + SIGMA_DN * rng.standard_normal((FRAMES, HEIGHT, WIDTH))
    raw += wander_dn * rng.standard_normal((FRAMES, 1, 1))
    stack = lit(filled_in(raw), "rgb8")
    found = [*correlations(stack, MOSAIC), beyond_the_next(stack, MOSAIC)]
    samples = FRAMES * (HEIGHT - 16) * (WIDTH - 16) / 2
    assert np.abs(found).max() < 4.5 / np.sqrt(samples)


@pytest.mark.parametrize(
    ("corners", "filtered", "row_dn", "told"),
    [
        (True, False, 0.0, True),
        (False, False, 0.0, False),
        (False, True, 0.0, False),
        (True, False, 2.0, True),  # noise of rows agrees along one direction
        (False, False, 2.0, False),
    ],
)
def test_a_demosaicer_that_averages_greens_is_told_by_their_noise(
    corners: bool, filtered: bool, row_dn: float, told: bool
) -> None:
    """Two fifths of n independent samples have the standard error 1 / sqrt(n), 0.003 here: a
    twentieth is far outside."""
    rng = np.random.default_rng(19)
    raw = 120 + SIGMA_DN * rng.standard_normal((FRAMES, HEIGHT, WIDTH))
    raw += row_dn * rng.standard_normal((FRAMES, HEIGHT, 1))
    picture = filled_in(raw)
    if corners:
        diagonal = np.array([[1, 0, 1], [0, 4, 0], [1, 0, 1]]) / 8
        green = np.zeros((HEIGHT, WIDTH), dtype=bool)
        green[0::2, 1::2] = green[1::2, 0::2] = True
        means = ndimage.convolve(raw, diagonal[None], mode="mirror")
        picture[..., 1] = np.where(green, means, picture[..., 1])
    if filtered:
        picture = ndimage.convolve(picture, window(0.08, 0.06)[None, :, :, None], mode="mirror")
    assert green_is_averaged([lit(picture, "rgb8")], MOSAIC) is told
