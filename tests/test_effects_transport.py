"""On the way out: what follows from each equation, and that an impostor fails it."""

from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
import pytest
from scipy import ndimage
from scipy.fft import dctn
from scipy.interpolate import interp1d

from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effects.chroma_subsampling import ChromaSubsampling
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.demosaic import Demosaic
from sensor.effects.demosaic_other import DemosaicOther
from sensor.effects.dropped_frames import DroppedFrames
from sensor.effects.jpeg import Jpeg
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.effects.sharpening import Sharpening
from sensor.effects.temporal_filter import TemporalFilter
from sensor.effects.white_balance import WhiteBalance
from sensor.errors import CameraError
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate
from tests.effects_bench import Array, flat, frames_of
from tests.effects_chain import (
    LIGHT_E,
    ROUNDING,
    Figures,
    applied,
    by_frame,
    noise_on,
    tells_apart,
)
from tests.harness import assert_agree, variance_error


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


def test_a_camera_rounds_once_where_colour_is_made_of_fractions() -> None:
    """The rounding of red, green and blue adds a twelfth of each one's weight squared to luma; as
    much again, and what both have in common, where they have been rounded before."""
    bare = Camera(
        name="bare", height=64, width=64, gain_dn_per_e=Colours.of(1.0), black_dn=128.0,
        effects=(ReadNoise(thermal_e=12.0), Demosaic()),
    )  # fmt: skip
    shot = Shot(label="dark", exposure_s=0.01, frames=16)
    fine = simulate(bare, shot, {}, seed=3, until=Quantity.DN).value.numpy()
    weights = np.array([0.299, 0.587, 0.114])

    def spread(of_whole_codes: float) -> float:
        effect = ChromaSubsampling(mode=1, whole_codes=0, of_whole_codes=of_whole_codes)
        full = bare.plus(Quantization(), effect)
        codes = pixels_of(full, simulate(full, shot, {}, seed=3)).astype(np.float64)
        return float(((codes - fine) @ weights).var())

    expected = (weights**2).sum() / 12
    assert_agree(spread(0.0), expected, variance_error(expected, fine[..., 0].size))
    assert spread(1.0) > 2 * expected


def shares(size: int, n: int, taken: int, drawn: int) -> tuple[Array, Array]:
    """What each pixel gives to the colour of a group, and that to a pixel, along one axis."""
    half = 0.5 if taken == 0 else 0.0
    groups, places = -(-size // n), np.arange(size)
    gives = np.zeros((groups, size))
    weights = [
        dict.fromkeys(range(n), 1 / n), {k: (n - abs(k)) / n**2 for k in range(1 - n, n)}, {0: 1.0}
    ][taken]  # fmt: skip
    for group in range(groups):
        for k, weight in weights.items():
            gives[group, min(max(n * group + k, 0), size - 1)] += weight
    place = (places + half) / n - half if drawn else (places // n).astype(float)
    place = np.clip(place, 0, groups - 1)
    return gives, np.maximum(1 - np.abs(np.subtract.outer(place, np.arange(groups))), 0)


@pytest.mark.parametrize("width", [64, 30])
@pytest.mark.parametrize("drawn", [0, 1])
@pytest.mark.parametrize("taken", [0, 1, 2])
@pytest.mark.parametrize(("mode", "rows"), [(1, 1), (2, 1), (1, 2)])
def test_chroma_is_taken_and_drawn_as_plain_arithmetic_has_it(
    mode: int, rows: int, taken: int, drawn: int, width: int
) -> None:
    """By two matrices along either axis."""
    before = np.round(noise_on(128.0, 12.0, 4, 10, width, 3))
    across, along = shares(width, 2**mode, taken, drawn)
    down, up = shares(10, rows, taken, drawn)
    luma = np.array([0.299, 0.587, 0.114])
    grey = before @ luma
    ways = "yr,rs,pg,gx,fsxc->fypc"
    colour = np.einsum(ways, up, down, along, across, before, optimize=True)
    red, blue = colour[..., 0] - colour @ luma, colour[..., 2] - colour @ luma
    green = grey - (0.299 * red + 0.114 * blue) / 0.587
    exact = np.stack([grey + red, green, grey + blue], axis=-1)
    effect = ChromaSubsampling(mode=mode, whole_codes=0, taken=taken, drawn=drawn, rows=rows)
    # a sum that ends at a half may be rounded either way
    assert np.abs(applied(effect, before) - np.clip(exact, 0, 255)).max() < 0.5 + 1e-4


def test_colours_are_drawn_as_planes_of_whole_codes() -> None:
    """Rounding moves V by v, evenly within a half, and red by x = 1.402 v before it is rounded
    itself: by one code in |x| of all pixels, so that it differs from red of colours in fractions by
    a variance of 1.402/4, and blue by 1.772/4. Where nothing is rounded they do not differ."""
    before = noise_on(128.0, 12.0, 16, 32, 64, 3)
    planes = [applied(ChromaSubsampling(mode=2, whole_codes=0, drawn=d), before) for d in (1, 2)]
    off = planes[1] - planes[0]
    for channel, weight in ((0, 1.402), (2, 1.772)):
        expected = weight / 4
        assert np.isin(off[..., channel], [-1.0, 0.0, 1.0]).all()
        error = np.sqrt(expected * (1 - expected) / off[..., channel].size)
        assert_agree(np.square(off[..., channel]).mean(), expected, error)


@pytest.mark.parametrize("rows", [1, 2])
@pytest.mark.parametrize("of_rounded_luma", [True, False])
def test_means_of_whole_codes_are_those_of_plain_arithmetic(
    rows: int, of_rounded_luma: bool
) -> None:
    """Y, U and V are rounded in each pixel, and the means of U and V again, halves up: by
    reshaping. In integers U and V are of that Y, and not of Y as it was before it was rounded; in
    planes of whole codes it is the other way round."""
    before = np.round(noise_on(128.0, 12.0, 16, 32, 64, 3))
    luma = np.round(before @ [0.299, 0.587, 0.114])

    def red_of(y: Array) -> Array:
        own = np.round((before[..., 0] - y) / 1.402)
        mean = np.floor(own.reshape(16, 32 // rows, rows, 32, 2).mean(axis=(2, 4)) + 0.5)
        return np.asarray(luma + 1.402 * mean.repeat(rows, axis=1).repeat(2, axis=2))

    effect = ChromaSubsampling(mode=1, whole_codes=2 if of_rounded_luma else 3, rows=rows)
    red = applied(effect, before)[..., 0]
    of = [luma, before @ [0.299, 0.587, 0.114]]
    # one in a thousand of Y ends at a half, which floats send either way
    apart = [np.abs(red - red_of(y)) > 0.5 + 1e-4 for y in (of if of_rounded_luma else of[::-1])]
    assert apart[0].mean() < 0.01 < 0.1 < apart[1].mean()


def test_colours_in_integers_are_those_of_opencv() -> None:
    """Its conversion, its means of two rows and columns, and its lines between them. Of faint codes
    all are the same; of colourful ones one in thirty-three is another, as OpenCV has three digits
    of the weights that BT.601 defines. In whole codes without its fixed point a tenth are."""

    def by_opencv(codes: Array) -> Array:
        height, width = codes.shape[1:3]
        made = []
        for frame in codes.astype(np.uint8):
            y, *colours = cv2.split(cv2.cvtColor(frame, cv2.COLOR_RGB2YCrCb))
            small = [cv2.resize(c, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
                     for c in colours]  # fmt: skip
            large = [cv2.resize(c, (width, height)) for c in small]
            made.append(cv2.cvtColor(cv2.merge([y, *large]), cv2.COLOR_YCrCb2RGB))
        return np.array(made, dtype=np.float64)

    y, x = np.mgrid[:64, :96]
    colourful = np.stack([90 + 40 * np.sin(x / 9), 100 + 50 * np.cos(y / 7), 60 + x / 2.0], axis=-1)
    effect = ChromaSubsampling(mode=1, whole_codes=2, rows=2, drawn=2)
    rng = np.random.default_rng(1)
    for mean, sigma, most in ((np.full((64, 96, 3), 3.0), 1.0, 0.0), (colourful, 4.0, 0.05)):
        codes = np.clip(np.round(mean + sigma * rng.standard_normal((4, 64, 96, 3))), 0, 255)
        ours, theirs = applied(effect, codes), by_opencv(codes)
        assert (ours != theirs).mean() <= most
        once = applied(dataclasses.replace(effect, whole_codes=1), codes)
        assert (once != theirs).mean() > 0.1


def test_colours_in_planes_are_those_of_plain_arithmetic() -> None:
    """A program that keeps Y, U and V as planes of whole codes, means of two rows and columns, and
    lines between their middles, which ends of rows do not have: by linear interpolation."""
    height, width = 32, 48
    rng = np.random.default_rng(4)
    before = np.round(110 + np.cumsum(rng.normal(0, 4, (4, height, width, 3)), axis=2))
    before = np.clip(before, 20, 235)
    luma = before @ [0.299, 0.587, 0.114]

    def drawn(colour: int, scale: float) -> Array:
        own = np.round((before[..., colour] - luma) / scale)
        small = np.floor(own.reshape(4, height // 2, 2, width // 2, 2).mean(axis=(2, 4)) + 0.5)
        for axis, size in ((1, height), (2, width)):
            at = (np.arange(size) - 0.5) / 2
            small = interp1d(np.arange(size // 2), small, axis=axis, fill_value="extrapolate")(at)
        return np.floor(small + 0.5)

    v, u = drawn(0, 1.402), drawn(2, 1.772)
    effect = ChromaSubsampling(mode=1, whole_codes=3, rows=2, drawn=2)
    green = np.round(luma) - (0.299 * 1.402 * v + 0.114 * 1.772 * u) / 0.587
    expected = np.stack([np.round(luma) + 1.402 * v, green, np.round(luma) + 1.772 * u], axis=-1)
    inside = np.s_[:, 1:-1, 1:-1]
    off = np.abs(applied(effect, before) - expected)[inside] > 0.5 + 1e-4
    assert off.mean() < 0.01
    fixed = np.abs(applied(dataclasses.replace(effect, whole_codes=2), before) - expected)[inside]
    assert (fixed > 0.5 + 1e-4).mean() > 0.1


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
    with pytest.raises(CameraError, match="expected a whole number from 0 to 5"):
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
