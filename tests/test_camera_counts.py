"""How the camera counts: rounding of its demosaicer, codes of its converter, lost bits."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy import ndimage

from foundation.backend import backend
from sensor.colours import Colours
from sensor.effects.demosaic import Demosaic
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate
from tests.backends import BACKENDS
from tests.harness import assert_agree, variance_error
from tests.plain_camera import GAIN, LIT, SIDE, camera, dark_shot, dn, rates


@pytest.mark.parametrize("where", BACKENDS)
def test_bilinear_demosaicing_keeps_samples_planes_and_the_noise_ratios(where: str) -> None:
    """Measured samples pass; a plane comes out as that plane; N_D of equations (4) to (7)."""
    b = backend(where)
    cam = camera(Demosaic(), pixels="rgb8", bits=8)
    y, x = np.mgrid[:SIDE, :SIDE]
    plane = (3.0 * x + 2.0 * y + 50.0).astype(np.float32)
    light = {"lamp": np.repeat(plane[..., None], 3, axis=2)}
    shot = dataclasses.replace(LIT, exposure_s=1.0, frames=1)
    out = simulate(cam, shot, light, where=b, until=Quantity.DN).numpy()[0]
    inner = (slice(1, -1), slice(1, -1))
    assert np.allclose(out[inner], (GAIN * plane + 100.0)[inner][..., None], atol=1e-3)

    noisy = dn(camera(ReadNoise(), Demosaic(), pixels="rgb8", bits=8), where)
    sigma = GAIN * math.sqrt(8**2 + 10**2 + 4**2)
    spread = noisy[:, 2:-2, 2:-2].std(0, ddof=1).mean((0, 1)) / sigma
    c4 = 1 - 1 / (4 * 23)
    expected = np.array([(1 + math.sqrt(2) + 0.5) / 4, 0.75, (1 + math.sqrt(2) + 0.5) / 4]) * c4
    pixels = (SIDE - 4) ** 2
    assert_agree(spread, expected, 0.75 / math.sqrt(2 * 23 * pixels / 4))


@pytest.mark.parametrize("cfa", ["RGGB", "GRBG"])
@pytest.mark.parametrize("where", BACKENDS)
def test_a_normalised_convolution_averages_measured_greens_and_nothing_else(
    where: str, cfa: str
) -> None:
    """Means of all samples of a colour in 3 x 3 by the weights 1 2 1, by SciPy. White noise keeps
    5/16 of its variance in a measured green, and has 1/8 of it in common with each corner's."""
    common = {"pixels": "rgb8", "bits": 8, "cfa": cfa}
    noisy, plain = (
        dn(camera(ReadNoise(), Demosaic(corners=corners), **common), where) for corners in (1, 0)
    )
    sites = np.tile(np.array(["RGB".index(c) for c in cfa]).reshape(2, 2), (SIDE // 2, SIDE // 2))
    samples = np.take_along_axis(plain, sites[None, ..., None], 3)[..., 0]
    tent = np.outer([1, 2, 1], [1, 2, 1])
    for colour in range(3):
        there = (sites == colour).astype(float)
        weight = ndimage.convolve(there, tent, mode="mirror")
        means = ndimage.convolve(samples * there, tent[None], mode="mirror") / weight
        assert np.allclose(noisy[..., colour], means, atol=1e-3)

    measured = np.where(sites == 1, noisy[..., 1] - noisy[..., 1].mean(0), 0.0)
    variance = measured[:, sites == 1].var(axis=0, ddof=1).mean()
    in_common = (measured[:, 1:, 1:] * measured[:, :-1, :-1])[:, (sites == 1)[1:, 1:]].mean()
    one = GAIN**2 * (8**2 + 10**2 + 4**2)
    independent = len(noisy) * SIDE**2 / 2 / 4  # a green shares its samples with its corners
    assert variance / one == pytest.approx(5 / 16, rel=4.5 * math.sqrt(2 / independent))
    expected = (1 - 1 / len(noisy)) / 8
    assert in_common / one == pytest.approx(expected, abs=4.5 / math.sqrt(independent))


HALVES = {1: lambda mean: np.floor(mean + 0.5), 2: np.round, 3: np.floor}


@pytest.mark.parametrize("arithmetic", HALVES)
@pytest.mark.parametrize("where", BACKENDS)
def test_a_demosaicer_in_whole_numbers_rounds_twice(where: str, arithmetic: int) -> None:
    """Each mean is that of whole neighbours, with halves sent where the rule says; one in fractions
    rounds the mean of what was never rounded, and one that rounds otherwise differs as well."""
    common = {"pixels": "rgb8", "bits": 8, "gain_dn_per_e": Colours.of(1.0), "black_dn": 0.0}
    raw = np.random.default_rng(arithmetic).uniform(3.0, 250.0, (SIDE, SIDE)).astype(np.float32)
    light = {"lamp": np.repeat(raw[..., None], 3, axis=2)}
    shot = dataclasses.replace(LIT, exposure_s=1.0, frames=1)

    def frame(rule: int) -> np.ndarray:
        cam = camera(Demosaic(arithmetic=float(rule)), Quantization(), **common)
        return pixels_of(cam, simulate(cam, shot, light, where=backend(where)))[0].astype(float)

    whole, red = np.round(raw.astype(float)), frame(arithmetic)[..., 0]
    beside = (whole[::2, :-2:2] + whole[::2, 2::2]) / 2
    corner = (beside[:-1] + beside[1:]) / 2
    assert np.array_equal(red[::2, 1:-1:2], HALVES[arithmetic](beside))
    assert np.array_equal(red[1:-1:2, 1:-1:2], HALVES[arithmetic](corner))
    assert np.array_equal(red[::2, ::2], whole[::2, ::2])
    for other in {0, 1, 2, 3} - {arithmetic}:
        assert not np.array_equal(red, frame(other)[..., 0])


def halves_up(dn: np.ndarray) -> np.ndarray:
    return np.floor(dn + 0.5)


@pytest.mark.parametrize("steps", [16, 4])
def test_finer_steps_are_rounded_with_halves_to_the_even_number_or_up(steps: int) -> None:
    """Of steps in equal numbers the even codes take one more and the odd ones one less, or all as
    many. Means of two and of four are fractions of steps, or whole steps with halves up, before the
    last rounding."""
    common = {"pixels": "rgb8", "bits": 8, "gain_dn_per_e": Colours.of(1.0), "black_dn": 0.0}
    rng = np.random.default_rng(steps)
    raw = (rng.integers(32 * steps, 64 * steps, (SIDE, SIDE)) / steps).astype(np.float32)
    light = {"lamp": np.repeat(raw[..., None], 3, axis=2)}
    shot = dataclasses.replace(LIT, exposure_s=1.0, frames=1)
    beside = (raw[::2, :-2:2] + raw[::2, 2::2]) / 2
    corner = (beside[:-1] + beside[1:]) / 2
    first = {16: 5.0, 4: 8.0}[steps]
    whole_steps = halves_up(steps * beside) / steps, halves_up(steps * corner) / steps
    for rule, last, (two, four) in (
        (first, np.round, (beside, corner)),
        (first + 1, halves_up, (beside, corner)),
        (first + 2, halves_up, whole_steps),
    ):
        cam = camera(Demosaic(arithmetic=rule), Quantization(), **common)
        red = pixels_of(cam, simulate(cam, shot, light))[0][..., 0]
        assert np.array_equal(red[::2, ::2], last(raw[::2, ::2]))
        assert np.array_equal(red[::2, 1:-1:2], last(two))
        assert np.array_equal(red[1:-1:2, 1:-1:2], last(four))


def test_a_converter_with_four_more_bits_leaves_sixteenths() -> None:
    """Measured samples are whole sixteenths, means of two whole halves of them, and rounding adds a
    variance of (1/16)^2 / 12."""
    read = ReadNoise(reset_e=0, thermal_e=6, other_e=0)
    common = {"pixels": "rgb8", "bits": 8, "gain_dn_per_e": Colours.of(1.0), "black_dn": 100.0}
    fine, coarse = (
        simulate(
            camera(read, Demosaic(arithmetic=a), **common), dark_shot(), {}, until=Quantity.DN
        ).value.numpy()
        for a in (0.0, 5.0)
    )
    red = coarse[:, ::2, ::2, 0]
    assert np.array_equal(red * 16, np.round(red * 16))
    between = coarse[:, ::2, 1::2, 0] * 32
    assert np.array_equal(between, np.round(between))
    assert np.any(between % 2 == 1)
    off = (red - fine[:, ::2, ::2, 0]).astype(np.float64)
    expected = 1 / 16**2 / 12
    assert_agree(off.var(), expected, variance_error(expected, off.size))


@pytest.mark.parametrize("where", BACKENDS)
def test_quantization_rounds_to_the_nearest_and_clips(where: str) -> None:
    cam = camera(Quantization(), gain_dn_per_e=Colours.of(1.0), black_dn=0.0)
    values = np.array([0.4, 0.6, 2.49, 2.51, 70_000.0, 5.0], np.float32)
    image = np.resize(values, (SIDE, SIDE))
    shot = dataclasses.replace(LIT, exposure_s=1.0, frames=1)
    light = {"lamp": np.repeat(image[..., None], 3, axis=2)}
    out = pixels_of(cam, simulate(cam, shot, light, where=backend(where)))[0]
    assert np.array_equal(out, np.resize([0, 1, 2, 3, 65535, 5], (SIDE, SIDE)))


def test_quantization_adds_a_twelfth_and_not_a_bias() -> None:
    """The faults of two neighbours: truncation shifts by -0.5 DN, rounding twice adds 1/6."""
    read = ReadNoise(reset_e=0, thermal_e=6, other_e=0)
    fine, coarse = dn(camera(read)), simulate(camera(read, Quantization()), LIT, rates())
    rounded = coarse.numpy().astype(np.float64)
    n = rounded.size
    added = (rounded - fine).var()
    assert_agree(
        [(rounded - fine).mean(), added],
        [0.0, 1 / 12],
        [math.sqrt(1 / 12 / n), math.sqrt((1 / 80 - 1 / 144) / n)],
    )


@pytest.mark.parametrize("steps", [4, 16])
def test_bits_that_are_dropped_make_even_codes_wider(steps: int) -> None:
    """n steps in a code, and halves to the even one: even codes are (n + 1) / 2n of all."""
    read = ReadNoise(reset_e=0, thermal_e=6, other_e=0)
    codes = simulate(camera(read, Quantization(steps=float(steps))), LIT, rates()).numpy()
    even, n = float(np.mean(codes % 2 == 0)), codes.size
    assert_agree(even, (steps + 1) / (2 * steps), math.sqrt(1 / 4 / n))
