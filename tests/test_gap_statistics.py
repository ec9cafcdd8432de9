"""Statistics of the diagnosis: what independent noise gives, and what each structure adds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage, stats

from analysis.bias.rounding import rounded
from analysis.gap.calibrate.darks import NODES, WEIGHTS, behind_rounding
from analysis.gap.camera.light import Light
from analysis.gap.camera.light_blocks import blocks_of, light_noise
from analysis.gap.look.families import (
    OF_A_BODY,
    OTHERWISE,
    REPEATED,
    REPEATED_IN_PART,
    STAGES,
    stage_of,
)
from analysis.gap.look.lattices import Lattice, lattices_of
from analysis.gap.look.observation import View
from analysis.gap.look.statistics.group import Group, crossed
from analysis.gap.look.statistics.pattern import pattern, pattern_shape
from analysis.gap.look.statistics.structure import (
    columns,
    frames,
    neighbours,
    rows,
    tails,
    time,
)
from analysis.gap.look.statistics.surface import surface
from analysis.gap.ready.interference import wave
from sensor.effect import Stage
from sensor.frames import Frames
from sensor.protocol import Shot
from tests.harness import SIGNIFICANCE
from tests.mosaic import colour_capture

FRAMES, HEIGHT, WIDTH = 8, 96, 128
SIGMA = 3.0


def group(structure: np.ndarray, seed: int = 1) -> Group:
    """White noise with something added, as codes around 100."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(0, SIGMA, (FRAMES, HEIGHT, WIDTH)) + structure
    return Group(codes=np.round(100 + noise).astype(np.uint8)[None], top_dn=255, lit=False)


def test_white_noise_has_no_structure() -> None:
    """Every covariance is 0 within four standard errors of a mean over its independent samples."""
    white = group(np.zeros(1))
    n = FRAMES * HEIGHT * WIDTH
    for found in (neighbours(white), time(white)):
        for name, value in found.items():
            assert abs(value) < 5.5 / np.sqrt(n * 5 / 8), name
    lines = FRAMES * HEIGHT * 7 / 8
    assert abs(rows(white)["row correlation"]) < 5.5 * np.sqrt(2 / lines) / WIDTH
    assert abs(columns(white)["column correlation"]) < 5.5 * np.sqrt(2 / lines) / HEIGHT


def test_a_noisy_pixel_stays_one_and_a_rare_event_does_not() -> None:
    """Of independent noise even and odd frames agree in nothing, however heavy its tails: the
    correlation over n pixels has the error n^-1/2. A hundredth of pixels k times as noisy has the
    closed form p (1 - p) (k^2 - 1)^2 over that plus the scatter 2 (mean of k^4) / (m - 1) of m
    frames."""
    rng = np.random.default_rng(4)
    n = HEIGHT * WIDTH
    stray = 90.0 * (rng.uniform(size=(FRAMES, HEIGHT, WIDTH)) < 0.001)
    for structure in (np.zeros(1), stray):
        assert abs(tails(group(structure))["pixel variance that stays"]) < 5 / np.sqrt(n)
    noisy, p, k = rng.uniform(size=(HEIGHT, WIDTH)) < 0.01, 0.01, 6.0
    codes = np.round(120 + SIGMA * (1 + (k - 1) * noisy) * rng.normal(size=(FRAMES, HEIGHT, WIDTH)))
    found = tails(Group(codes=codes[None], top_dn=255, lit=False))["pixel variance that stays"]
    between = p * (1 - p) * (k**2 - 1) ** 2
    within = 2 * (1 + p * (k**4 - 1)) / (FRAMES // 2 - 1)
    assert found == pytest.approx(between / (between + within), abs=0.1)


def test_of_loud_pixels_those_stay_that_are_loud_by_themselves() -> None:
    """50 pixels that jump up and down between any two frames are loud in even frames and in odd
    ones, n / (n + 5); as many jumps of as many pixels, one each, in one of the two alone. Noise has
    no loud pixels, and a lit shot has them where it is bright."""
    rng = np.random.default_rng(8)
    places = rng.permutation(HEIGHT * WIDTH)[:50]

    def stay(jumps: np.ndarray, *, lit: bool = False) -> float | None:
        noise = 120 + SIGMA * rng.normal(size=(FRAMES, HEIGHT * WIDTH))
        codes = np.round(noise + 60.0 * jumps).reshape(1, FRAMES, HEIGHT, WIDTH)
        found = tails(Group(codes=codes, top_dn=255, lit=lit)).get("loud pixels that stay")
        return None if found is None else float(found[0])

    jumping = np.zeros((FRAMES, HEIGHT * WIDTH))
    jumping[:, places] = np.arange(FRAMES)[:, None] // 2 % 2
    alone = np.zeros((FRAMES, HEIGHT * WIDTH))
    alone[rng.integers(0, FRAMES, 50), places] = 1.0
    assert stay(jumping) == pytest.approx(50 / 55)
    assert stay(alone) == 0.0
    assert stay(np.zeros(1)) == 0.0
    assert stay(jumping, lit=True) is None


def test_rough_edges_of_a_picture_are_no_pattern() -> None:
    """Where light of a patch meets that of the next it is rough by a tenth, a pattern has 1 %: its
    variance over the square of light is 1 in units of 1e-4, to 5 times the error of some 6,000
    samples of which neighbours share a ninth each; with the edges in it, it is 2 and more."""
    rng = np.random.default_rng(9)
    board = np.where(np.add.outer(range(4), range(4)) % 2, 60.0, 180.0)
    patches = np.kron(board, np.ones((HEIGHT // 4, WIDTH // 4)))
    edge = ndimage.morphological_gradient(patches, size=3) > 0
    light = patches * (1 + 0.1 * edge * rng.standard_normal(patches.shape))
    light *= 1 + 0.01 * rng.standard_normal(patches.shape)
    codes = light + rng.normal(0, 0.5, (FRAMES, HEIGHT, WIDTH))
    found = pattern(Group(codes=codes[None].astype(np.float32), top_dn=255, lit=True))
    error = np.sqrt(2 * 3 / 6000)
    assert found["pattern variance"] == pytest.approx(1.0, abs=5 * error)


@pytest.mark.parametrize("part", [0.2, 0.5])
def test_row_noise_is_a_share_of_the_variance(part: float) -> None:
    """Rows of standard deviation part x sigma: covariance part^2 / (1 + part^2) of the variance."""
    rng = np.random.default_rng(2)
    offsets = rng.normal(0, part * SIGMA, (FRAMES, HEIGHT, 1))
    found = rows(group(offsets))["row correlation"]
    total = SIGMA**2 * (1 + part**2) + 1 / 12
    expected = part**2 * SIGMA**2 / total
    error = expected * np.sqrt(2 / (FRAMES * HEIGHT * 7 / 8)) * 1.3
    assert abs(found - expected) < 5 * error
    independent = rng.normal(0, part * SIGMA, (FRAMES, HEIGHT, WIDTH))
    impostor = rows(group(independent))["row correlation"]
    assert abs(impostor - expected) > 5 * error


def test_frames_that_drift_wander_and_frames_that_jump_do_not() -> None:
    """Over n frames a slope b has a variance of n (n + 1) / 12 b^2, its steps show b^2 / 2 of it.
    With v / p of independent noise in the mean of p pixels both are cube roots of 1 + p / v times
    that. Jumps of the same variance show more than all of it in their steps. Over the noise the
    errors are those of n - 1 squares and of its product with the slope: a tenth, at 4 of them."""
    slope, pixels = 0.2, HEIGHT * WIDTH
    noise = SIGMA**2 + 1 / 12
    spread, wander = (
        np.cbrt(1 + part * slope**2 * pixels / noise)
        for part in (1 / 2, FRAMES * (FRAMES + 1) / 12)
    )
    found = frames(group(slope * np.arange(FRAMES)[:, None, None], seed=3))
    assert found["frame spread"] == pytest.approx(spread, rel=0.15)
    assert found["frame wander"] == pytest.approx(wander - spread, rel=0.15)
    jumps = slope * np.sqrt(FRAMES * (FRAMES + 1) / 12) * np.array([1, -1] * (FRAMES // 2))
    impostor = frames(group(jumps[:, None, None], seed=3))
    assert impostor["frame wander"] < 0
    assert impostor["frame spread"] > 2 * spread


def test_the_spread_of_independent_frames_is_all_but_normal() -> None:
    """A mean square of 7 has a skewness of 1.1 and its cube root 0.1 or less; of steps, whose
    squares are not independent, 1.3 and 0.2. Over 400 groups an error of sqrt(6 / 400) = 0.12,
    at 4."""
    rng = np.random.default_rng(4)
    codes = np.round(100 + rng.normal(0, SIGMA, (400, FRAMES, 16, 16))).astype(np.uint8)
    spreads = frames(Group(codes=codes, top_dn=255, lit=False))["frame spread"]
    assert abs(stats.skew(spreads)) < 0.2 + 4 * 0.12
    assert stats.skew(np.power(spreads, 3)) > 0.2 + 4 * 0.12


def test_the_surface_of_the_dark_has_the_slope_and_the_corner_that_were_put_in() -> None:
    """A slope s along x has the coefficient s. A corner that glows by g is g less its own share of
    the mean above the rest. Errors are those of means of independent samples."""
    slope, glow = 0.4, 0.5
    tilted = np.linspace(-slope, slope, WIDTH)[None, None, :]
    corner = np.zeros((1, HEIGHT, WIDTH))
    corner[:, -(HEIGHT // 6) :, : WIDTH // 6] = glow
    samples = FRAMES * HEIGHT * WIDTH
    error = np.sqrt((SIGMA**2 + 1 / 12) / samples)
    found = surface(group(tilted, seed=5))
    assert abs(found["surface x"] - slope) < 5 * np.sqrt(3) * error + 0.01 * slope
    assert abs(found["surface y"]) < 5 * np.sqrt(3) * error
    found = surface(group(corner, seed=6))
    rest = 1 - (HEIGHT // 6) * (WIDTH // 6) / (HEIGHT * WIDTH)
    assert abs(found["surface, bottom left"] - glow * rest) < 5 * 6 * error
    assert abs(found["surface, top right"]) < glow * (1 - rest) + 5 * 6 * error


def test_crossed_differences_see_no_edges_but_keep_variance() -> None:
    """Upright edges and shading vanish; independent samples keep their variance."""
    y, x = np.mgrid[:80, :100]
    picture = (50.0 * (x > 40) + 30.0 * (y > 20) + 0.2 * x + 0.1 * y).astype(np.float32)
    assert np.abs(crossed(picture)).max() < 1e-4
    noise = np.random.default_rng(3).normal(0, 2.0, (400, 400)).astype(np.float32)
    # neighbours of the stencil overlap: the error of the variance is that of n / 9 samples or so
    assert crossed(noise).var() == pytest.approx(4.0, rel=5 * np.sqrt(2 * 9 / 400**2))


@pytest.mark.parametrize(
    ("black", "read", "fpn"), [(3.0, 0.26, 0.15), (5.4, 0.5, 0.2), (4.0, 1.5, 0.3)]
)
def test_darks_behind_rounding_give_their_figures_back(
    black: float, read: float, fpn: float
) -> None:
    """Moments after rounding, solved for what is behind it, to a part in a thousand."""
    pixel = rounded(black + NODES * fpn, read, 255)
    mean = float(WEIGHTS @ pixel.mean_dn)
    found = behind_rounding(
        mean,
        float(WEIGHTS @ np.square(pixel.sd_dn)),
        float(WEIGHTS @ np.square(pixel.mean_dn - mean)),
        255,
    )
    assert found == pytest.approx([black, read**2, fpn**2], rel=2e-2, abs=1e-3)


@pytest.mark.parametrize("period", [23.7, 3.3, 500.0])
def test_a_wave_along_the_read_out_tells_its_period(period: float) -> None:
    """A sinusoid half as strong as the noise, found to a tenth of the frequency resolution."""
    rng = np.random.default_rng(6)
    count = np.arange(HEIGHT * WIDTH).reshape(HEIGHT, WIDTH)
    drift = 0.31 * np.arange(16)[:, None, None]
    bars = 1.5 * np.sin(2 * np.pi * (count / period + drift))
    dn = np.round(100 + rng.normal(0, SIGMA, (16, HEIGHT, WIDTH)) + bars).astype(np.uint8)
    shot = Shot(label="a", light=("lamp",), exposure_s=0.01, frames=16)
    stack = Frames(dn=dn, shot=shot, pixels="mono8", bits=8)
    grey = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)
    found = {name: float(value) for name, value in wave([stack], grey).items()}
    assert HEIGHT * WIDTH * abs(1 / found["period_px"] - 1 / period) < 0.5
    assert found["blanking_px"] == 0
    assert found["drift_cycles_per_frame"] == pytest.approx(0.31, abs=0.01)
    assert found["jitter_cycles"] == 0


@pytest.mark.parametrize("walk", [0.0, 0.02, 0.08])
def test_a_wave_that_runs_freely_tells_its_walk(walk: float) -> None:
    """Of eight shots of 16 frames some hundred steps are known to a tenth; none is none."""
    rng = np.random.default_rng(26)
    count = np.arange(HEIGHT * WIDTH).reshape(HEIGHT, WIDTH)
    grey = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)
    stacks = []
    for label in "abcdefgh":
        phase = np.cumsum(walk * rng.standard_normal(16)) + 0.21 * np.arange(16)
        bars = 4.0 * np.sin(2 * np.pi * (count / 7.11 + phase[:, None, None]))
        dn = np.round(100 + rng.normal(0, SIGMA, (16, HEIGHT, WIDTH)) + bars).astype(np.uint8)
        shot = Shot(label=label, light=("lamp",), exposure_s=0.01, frames=16)
        stacks.append(Frames(dn=dn, shot=shot, pixels="mono8", bits=8))
    found = {name: float(value) for name, value in wave(stacks, grey).items()}
    assert found["walk_cycles"] == pytest.approx(walk, rel=0.3, abs=1e-9)
    assert found["jitter_cycles"] == 0


def test_a_wave_that_lines_turn_tells_their_blanking() -> None:
    """A sinusoid half as strong as the noise, of 0.1497 cycles a pixel and 0.0631 a row and any
    phase in each frame: both are found to a tenth of the resolution of a frame."""
    rng = np.random.default_rng(16)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    phase = rng.uniform(size=(16, 1, 1))
    turned = 1.5 * np.sin(2 * np.pi * (0.1497 * x + 0.0631 * y + phase))
    dn = np.round(100 + rng.normal(0, SIGMA, (16, HEIGHT, WIDTH)) + turned).astype(np.uint8)
    shot = Shot(label="a", light=("lamp",), exposure_s=0.01, frames=16)
    stack = Frames(dn=dn, shot=shot, pixels="mono8", bits=8)
    grey = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)
    found = {name: float(value) for name, value in wave([stack], grey).items()}
    assert WIDTH * abs(1 / found["period_px"] - 0.1497) < 0.1
    row = (WIDTH + found["blanking_px"]) / found["period_px"] % 1.0
    assert HEIGHT * abs(row - 0.0631) < 0.1
    assert found["jitter_cycles"] == 1


def test_the_noise_of_light_paths_is_that_of_the_blocks() -> None:
    """Rates drawn anew with the stated variance move each block by what `light_noise` says: mean
    squares over 300 draws follow chi-squared, the largest and the smallest of all blocks too."""
    rng = np.random.default_rng(8)
    rate = rng.uniform(1e4, 1e5, (HEIGHT, WIDTH, 3)).astype(np.float32)
    noise = (rng.uniform(0.01, 0.1, rate.shape) * rate).astype(np.float32) ** 2
    capture = colour_capture("RGGB")
    view = View(lattices=lattices_of(capture), frames=2, side=4, top_dn=255)
    light = Light(
        rates={"lamp": rate}, noise={"lamp": noise}, panels=(), known=True, source="drawn"
    )
    told = light_noise(light, view, ("R", "G", "B"))["lamp"]
    still = blocks_of(rate, view, ("R", "G", "B"))
    moved = [
        blocks_of(rate + np.sqrt(noise) * rng.standard_normal(rate.shape), view, ("R", "G", "B"))
        for _ in range(300)
    ]
    ratio = np.square(np.array(moved) / still - 1).mean(axis=0) / told
    chance = SIGNIFICANCE / ratio.size / 2
    assert ratio.min() > stats.chi2.ppf(chance, 300) / 300
    assert ratio.max() < stats.chi2.isf(chance, 300) / 300
    assert abs(ratio.mean() - 1) < 4.5 * np.sqrt(2 / 300 / ratio.size)


def test_skewness_of_a_pattern_without_any_is_normal() -> None:
    """Of 200 bodies 38 % are within half a standard deviation of the mean; a bare cube root, which
    is steep at zero, leaves far fewer there."""
    rng = np.random.default_rng(12)
    offsets = rng.normal(20, 1.0, (200, 1, 48, 64))
    codes = np.round(offsets + rng.normal(0, 1.0, (200, 4, 48, 64))).astype(np.uint8)
    found = pattern_shape(Group(codes=codes, top_dn=255, lit=False))["pattern skewness"]
    share = float(np.mean(np.abs(found - found.mean()) < found.std() / 2))
    assert share == pytest.approx(0.383, abs=3.5 * np.sqrt(0.383 * 0.617 / 200))


def test_every_statistic_is_of_a_stage() -> None:
    """Of its family's, but for those that tell of the cable or of what is read out."""
    stages = {stage.value for stage in Stage}
    assert set(STAGES.values()) | set(OTHERWISE.values()) <= stages
    assert set(STAGES) >= OF_A_BODY
    for lit in (True, False):
        assert stage_of("tails", "spread of pixel variance", lit=lit) == "photosite"
        assert stage_of("tails", "kurtosis", lit=lit) == "readout"
        assert stage_of("interpolation", "grid of 8, down", lit=lit) == "transport"
        assert stage_of("time", REPEATED, lit=lit) == "transport"
        assert stage_of("time", REPEATED_IN_PART, lit=lit) == "transport"
    assert stage_of("texture", "residual power", lit=True) == "optics"
    assert stage_of("texture", "residual power", lit=False) == "photosite"
