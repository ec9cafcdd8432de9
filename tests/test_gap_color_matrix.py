"""A matrix that mixed colours is told by how the noise of a picture's channels agrees."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from analysis.gap.ready.color_matrix import LEAST_PART, _parts, _vivid, matrix_of, mixed
from analysis.gap.ready.hints import DirectReading
from sensor.effects.color_matrix import ColorMatrix
from sensor.frames import Frames
from tests.mosaic import MOSAIC, filled_in, lit

FRAMES, HEIGHT, WIDTH = 16, 144, 160
SIGMAS_DN = np.array([5.0, 4.0, 7.0])
"""Of red, green and blue samples."""

PLAIN = np.eye(3)
VIVID = np.array([[1.3, -0.2, -0.1], [-0.15, 1.25, -0.1], [-0.03, -0.27, 1.3]])
SLIGHT = np.array([[1.0, 0.0, 0.0], [-0.06, 1.06, 0.0], [0.0, 0.0, 1.0]])


def picture(matrix: np.ndarray, seed: int) -> np.ndarray:
    """Grey of 120 DN with noise of a mosaic RGGB, filled in and mixed: (N, H, W, 3)."""
    sites = np.tile(SIGMAS_DN[[[0, 1], [1, 2]]], (HEIGHT // 2, WIDTH // 2))
    noise = sites * np.random.default_rng(seed).standard_normal((FRAMES, HEIGHT, WIDTH))
    return np.asarray(120 + filled_in(noise) @ matrix.T)


def shot(dn: np.ndarray) -> list[Frames]:
    return [lit(dn, "rgb8")]


@pytest.mark.parametrize("matrix", [VIVID, SLIGHT])
@pytest.mark.parametrize("seed", [3, 4, 5])
def test_the_matrix(matrix: np.ndarray, seed: int) -> None:
    """A covariance is known to 1 / sqrt(n) of both deviations, and so is a part of the matrix times
    the ratio of two colours' noise and what the eigenvalues' distance makes of it: thirty other
    draws scatter by 2.4 / sqrt(n) at most. At 5 such errors for 54 parts."""
    n = FRAMES * (HEIGHT - 16) * (WIDTH - 16) / 4
    told = mixed(shot(picture(matrix, seed)), MOSAIC)
    assert told is not None
    assert np.abs(matrix_of(told) - matrix).max() < 5 * 2.4 / np.sqrt(n)


def test_colours_that_are_more_vivid_are_one_number_before_they_are_six() -> None:
    """The saturation is half as uncertain as a part: it is read from six of them."""
    n = FRAMES * (HEIGHT - 16) * (WIDTH - 16) / 4
    told = mixed(shot(picture(ColorMatrix(saturation=1.2).matrix, 3)), MOSAIC)
    assert told is not None
    assert told.instead is not None
    assert told.hints["saturation"] == pytest.approx(1.2, abs=5 * 2.4 / np.sqrt(n))
    assert told.hints["next_colour"] == told.hints["last_colour"] == 0.0
    assert told.instead.hints["saturation"] == 1.0
    other = mixed(shot(picture(VIVID, 3)), MOSAIC)
    assert other is not None
    assert other.instead is None


@pytest.mark.parametrize("seed", range(6, 16))
def test_no_matrix(seed: int) -> None:
    """Without one, a part is its error of 0.007, and the largest of a picture 1.1 times what two
    halves say errors are, at most 4.1 times in thirty draws: it has to be 8 times and 0.02."""
    assert mixed(shot(picture(PLAIN, seed)), MOSAIC) is None


def test_what_else_makes_colours_agree() -> None:
    """Colour differences that are smoothed, and noise that all colours share, are no matrix."""
    dn = picture(PLAIN, 2)
    luma = dn @ np.array([0.299, 0.587, 0.114])
    rest = ndimage.uniform_filter(dn - luma[..., None], (0, 1, 2, 0))
    smooth = ndimage.uniform_filter(rest, (0, 0, 2, 0))
    assert mixed(shot(luma[..., None] + smooth), MOSAIC) is None
    shared = 2 * np.random.default_rng(3).standard_normal(dn.shape[:3])
    assert mixed(shot(dn + shared[..., None]), MOSAIC) is None


def test_a_matrix_too_small_to_be_told() -> None:
    part = LEAST_PART / 4
    small = np.array([[1 - part, part, 0], [0, 1, 0], [0, 0, 1]])
    assert mixed(shot(picture(small, 7)), MOSAIC) is None


def test_grey_frames_have_no_colours_to_mix() -> None:
    assert mixed([lit(picture(VIVID, 3)[..., 0], "mono8")], MOSAIC) is None


@pytest.mark.parametrize("saturation", [2.0, 3.0])
def test_parts_of_a_strong_saturation_stay_inside_their_ranges(saturation: float) -> None:
    """From 1 + 1 / 0.587 on green's part would be below -1, which no camera file takes."""
    mix = ColorMatrix(saturation=saturation).matrix
    told = matrix_of(DirectReading(hints=_parts(mix)))
    most = np.abs(told - np.diag(np.diag(told))).max()
    assert most == pytest.approx(min(1.0, 0.587 * (saturation - 1.0)))
    assert _vivid(mix) == pytest.approx(saturation)
    assert _vivid(ColorMatrix(saturation=3.0).matrix * 1.2 - 0.2 * np.eye(3)) == 3.0
