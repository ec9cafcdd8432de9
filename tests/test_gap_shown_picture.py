"""A picture tells by itself what light is like within its pixels, and how it was blurred."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.calibrate.finer_light import CLEAN
from analysis.gap.calibrate.shown_picture import (
    LARGEST_PX,
    Likeliest,
    Picture,
    likeliest,
    picture_of,
)
from analysis.gap.camera.blur import Blur, Within, softened
from analysis.gap.camera.light import Light
from analysis.gap.camera.light_of_frames import CLEAR_OF_THE_TOP
from analysis.gap.look.lattices import SITES, Lattice
from sensor.frames import Frames
from sensor.protocol import Shot

HEIGHT, WIDTH, FINER = 120, 160, 4
SIGMA_PX, PATTERN, TOP_DN = 0.5, 0.01, 255.0
LATTICES = tuple(
    Lattice(name=name, channel=name[0], dy=dy, dx=dx, step=2)
    for name, (dy, dx) in zip(("R", "G1", "G2", "B"), SITES, strict=True)
)


def patches(sigma_px: float) -> NDArray[np.float64]:
    """Hard edges every 15.25 px at four times the resolution, behind a blur."""
    rng = np.random.default_rng(3)
    fine = np.kron(rng.uniform(10, 200, (8, 11, 3)), np.ones((61, 61, 1)))
    sigma = FINER * sigma_px
    return np.asarray(ndimage.gaussian_filter(fine, (sigma, sigma, 0)))[
        : HEIGHT * FINER, : WIDTH * FINER
    ]


def pixels(fine: NDArray[np.float64]) -> NDArray[np.float32]:
    means = fine.reshape(HEIGHT, FINER, WIDTH, FINER, 3).mean((1, 3))
    return np.asarray(means, dtype=np.float32)


def picture(rate: NDArray[np.float32], soft: NDArray[np.float32]) -> Picture:
    """What a mosaic with a fixed pattern shows of a soft picture of a light."""
    rng = np.random.default_rng(8)
    dn = 3.0 + soft * (1.0 + PATTERN * rng.standard_normal(soft.shape))
    return Picture(
        dn=tuple(one.of(dn[None])[0].astype(np.float64) for one in LATTICES),
        rate=rate,
        lattices=LATTICES,
        top_dn=CLEAR_OF_THE_TOP * TOP_DN,
    )


def best_of(shown: Picture) -> Likeliest:
    found = [likeliest(shown, within) for within in get_args(Within)]
    return max(found, key=lambda one: one.log_likelihood)


@pytest.mark.parametrize(
    ("within", "before_px"), [("points", 0.8), ("smooth", 0.8), ("edges", 0.0)]
)
def test_the_likeliest_light_is_the_one_that_was_blurred(within: Within, before_px: float) -> None:
    """Light that is out of focus by 0.8 px, or has hard edges, before it was made of pixels; or the
    pixels themselves. A variance is known from thousands of samples to a few hundredths."""
    rate = pixels(patches(before_px))
    variance_px2 = SIGMA_PX**2
    if within == "points":
        soft = softened(rate, Blur(variance_px2=variance_px2))
    else:
        soft = pixels(patches(float(np.hypot(before_px, SIGMA_PX))))
    found = best_of(picture(rate, soft))
    assert found.blur.within == within
    assert found.blur.variance_px2 == pytest.approx(variance_px2, rel=0.1)
    assert found.at_edges < CLEAN


def test_a_picture_that_lies_elsewhere_shows_at_edges() -> None:
    """By a quarter of a pixel, which no blur makes."""
    rate = pixels(patches(0.8))
    moved = np.roll(patches(float(np.hypot(0.8, SIGMA_PX))), 1, axis=1)
    assert best_of(picture(rate, pixels(moved))).at_edges > CLEAN


@pytest.mark.parametrize("within", get_args(Within))
@pytest.mark.parametrize("lit_rows", [0, 12, HEIGHT])
def test_pictures_without_noise_or_for_the_most_part_without_light_say_something_finite(
    within: Within, lit_rows: int
) -> None:
    rate = pixels(patches(0.8))
    rate[lit_rows:] = 0.0
    dark = Picture(
        dn=tuple(np.full((52, 72), 3.0) for _ in LATTICES),
        rate=rate,
        lattices=LATTICES,
        top_dn=CLEAR_OF_THE_TOP * TOP_DN,
    )
    for shown in (dark, picture(rate, rate)):
        found = likeliest(shown, within)
        assert np.isfinite([found.log_likelihood, found.at_edges, found.blur.variance_px2]).all()


def test_the_brightest_clear_picture_is_taken_in_the_phase_of_its_mosaic() -> None:
    height, width = LARGEST_PX[0] + 10, LARGEST_PX[1] + 6
    levels = {"dark": 3, "dim": 40, "bright": 180, "white": 255}
    frames = [
        Frames(
            shot=Shot(label=label, exposure_s=0.01, light=() if label == "dark" else ("lamp",),
                      level=() if label == "dark" else (1.0,), frames=2),
            dn=np.full((2, height, width, 3), dn, np.uint8),
            pixels="rgb8",
            bits=8,
        )
        for label, dn in levels.items()
    ]  # fmt: skip
    light = Light(
        rates={"lamp": np.ones((height, width, 3), np.float32)},
        noise={}, panels=(), known=True, source="one",
    )  # fmt: skip
    shown = picture_of(frames, light, LATTICES)
    assert shown is not None
    assert shown.rate.shape[:2] == LARGEST_PX
    assert all(np.all(dn == levels["bright"]) for dn in shown.dn)
    assert picture_of(frames[-1:], light, LATTICES) is None
