"""A picture is blurred before it is made of pixels."""

from __future__ import annotations

import dataclasses
from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage, stats

from analysis.gap.camera.blur import PARTS, Blur, Within, softened
from analysis.gap.diagnose import calibrated
from analysis.gap.measure.measured import measured
from analysis.gap.ready.setting import look
from render.rate import RateHeader, RateImage, rate_image
from sensor.record import record
from tests.short import HEIGHT, PROTOCOL, WIDTH, camera

FINER = 4
SIGMA_PX = 0.6


def step(edge_px: float, sigma_px: float, width: int = 12) -> NDArray[np.float64]:
    """Means over pixels of a step that is blurred: of Phi((x - e) / s) over [i, i + 1] they are
    s (G(b) - G(a)) with G(z) = z Phi(z) + phi(z) and a, b the pixel's ends."""
    z = (np.arange(width + 1) - edge_px) / sigma_px
    means = sigma_px * np.diff(z * stats.norm.cdf(z) + stats.norm.pdf(z))
    return np.asarray(means)


def picture(row: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.repeat(np.repeat(row[None, :, None], 8, axis=0), 3, axis=2).astype(np.float32)


@pytest.mark.parametrize("edge_px", [5.0, 5.17, 5.5, 5.83])
@pytest.mark.parametrize("sigma_px", [0.3, 0.6, 1.2])
def test_an_edge_anywhere_in_a_pixel_is_blurred_as_if_it_were_seen(
    edge_px: float, sigma_px: float
) -> None:
    """An edge is placed to half of a part; phi(0) / s is how steep it can be, and a part's own
    variance adds to the blur's."""
    sharp, blurred = step(edge_px, 1e-6), step(edge_px, sigma_px)
    blur = Blur(variance_px2=sigma_px**2, within="edges")
    seen = softened(picture(sharp), blur)
    part = 1.0 / PARTS
    bound = stats.norm.pdf(0) / sigma_px * part**2 + part**2 / (12 * sigma_px**2)
    np.testing.assert_allclose(seen[4, :, 1], blurred, atol=bound)
    down = softened(picture(sharp).swapaxes(0, 1), blur)
    np.testing.assert_allclose(down[:, 4, 1], blurred, atol=bound)


def test_means_of_pixels_alone_are_blurred_to_something_else() -> None:
    sharp, blurred = step(5.5, 1e-6), step(5.5, SIGMA_PX)
    without, with_edges = (
        softened(picture(sharp), Blur(variance_px2=SIGMA_PX**2, within=within))[4, :, 1]
        for within in get_args(Within)[::2]
    )
    off, less = (np.abs(one - blurred).max() for one in (without, with_edges))
    assert off > 0.015 > 10 * less


@pytest.mark.parametrize("wave_px", [2.4, 4.0, 9.6])
@pytest.mark.parametrize("sigma_px", [0.3, 0.5, 1.2])
def test_smooth_light_loses_of_each_wave_what_its_length_says(
    wave_px: float, sigma_px: float
) -> None:
    """Of a wave of w radians in a pixel a normal distribution leaves exp(-s^2 w^2 / 2). One that is
    taken at whole pixels leaves the same of all waves that look like it there, by Poisson's sum."""

    def left(w: float) -> float:
        return float(np.exp(-(sigma_px**2) * w**2 / 2))

    w = 2 * np.pi / wave_px
    # it is its own mirror half a pixel beyond both borders
    row = 1.0 + np.cos(w * (np.arange(48) + 0.5))
    smooth, points = (
        softened(picture(row), Blur(variance_px2=sigma_px**2, within=within))[4, 12:-12, 1] - 1
        for within in ("smooth", "points")
    )
    wave = row[12:-12] - 1
    np.testing.assert_allclose(smooth, left(w) * wave, atol=1e-5)
    orders = 2 * np.pi * np.arange(-6, 7)
    of_points = sum(left(w + k) for k in orders) / sum(left(k) for k in orders)
    np.testing.assert_allclose(points, of_points * wave, atol=2e-3)


@pytest.mark.parametrize("within", get_args(Within))
def test_a_blur_moves_light_and_makes_none(within: Within) -> None:
    rng = np.random.default_rng(5)
    rate = np.zeros((40, 48, 3), np.float32)
    rate[10:-10, 12:-12] = rng.uniform(0, 1e5, (20, 24, 3))
    soft = softened(rate, Blur(variance_px2=1.0, within=within))
    np.testing.assert_allclose(soft.sum((0, 1)), rate.sum((0, 1)), rtol=1e-4)
    assert softened(rate, Blur(variance_px2=0.0, within=within)) is rate
    even = np.full_like(rate, 7.0)
    np.testing.assert_allclose(
        softened(even, Blur(variance_px2=1.0, within=within)), 7.0, rtol=1e-5
    )


def lamp_of(fine: NDArray[np.float64]) -> RateImage:
    """Light at four times the resolution as rates of pixels."""
    rate = fine.reshape(HEIGHT, FINER, WIDTH, FINER, 3).mean((1, 3)).astype(np.float32)
    return rate_image(rate, np.zeros_like(rate), RateHeader(scene="patches", lamp="lamp"))


def patches() -> NDArray[np.float64]:
    """Hard edges every 15.25 px, at four times the resolution."""
    rng = np.random.default_rng(11)
    fine = np.kron(rng.uniform(0.1, 1.0, (7, 9, 3)), np.ones((61, 61, 1)))
    return np.asarray(4.5e5 * fine[: HEIGHT * FINER, : WIDTH * FINER])


def out_of_focus() -> NDArray[np.float64]:
    """The same behind a lens that spreads it over a pixel already."""
    return soft(patches(), 0.8)


def soft(fine: NDArray[np.float64], sigma_px: float) -> NDArray[np.float64]:
    """Light at four times the resolution behind a normal distribution."""
    sigma = sigma_px * FINER
    return np.asarray(ndimage.gaussian_filter(fine, (sigma, sigma, 0)))


@pytest.mark.whole
@pytest.mark.parametrize(
    ("fine", "sigma_px", "within"),
    [
        (patches(), 0.6, "edges"),
        (out_of_focus(), 0.45, "smooth"),
        (patches(), 0.6, "points"),
    ],
    ids=["edges", "smooth", "points"],
)
def test_calibration_tells_what_light_is_like_within_pixels(
    fine: NDArray[np.float64], sigma_px: float, within: Within
) -> None:
    """It was blurred before it was made of pixels, or, in the last case, afterwards."""
    stated = lamp_of(fine)
    if within == "points":
        rate = ndimage.gaussian_filter(stated.rate_e_per_s, (sigma_px, sigma_px, 0))
        falls = dataclasses.replace(stated, rate_e_per_s=rate)
    else:
        falls = lamp_of(soft(fine, sigma_px))
    taken = record(camera().with_body(7), PROTOCOL, {"lamp": falls.rate_e_per_s}, seed=7)
    setting = look(taken, {"lamp": stated})
    assert setting is not None
    known = calibrated(setting, None)
    assert known.base.within == within
    assert known.base.blur_px2 == pytest.approx(sigma_px**2, rel=0.2)
    assert measured(known, setting.seen).whole.p_value > 0.01
