"""What the diagnosis reads from the frames themselves, before any fit."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from analysis.gap.look import jpeg_tables
from analysis.gap.look.chroma import shared_colours
from analysis.gap.look.comb import histograms
from analysis.gap.look.curve import curve, nearly_straight, powered
from analysis.gap.look.gains_by_teeth import gains_by_teeth
from analysis.gap.look.lattices import Lattice
from analysis.gap.look.whole_gains import white_balance
from analysis.gap.ready.hints import dwell_s, empty_bits
from sensor.effects.chroma_subsampling import ChromaSubsampling
from sensor.frames import Frames
from sensor.protocol import Shot
from tests.effects_chain import applied

SITES = tuple(
    Lattice(name=name, channel=name[0], dy=dy, dx=dx, step=2)
    for name, dy, dx in (("R", 0, 0), ("G1", 0, 1), ("G2", 1, 0), ("B", 1, 1))
)
TOP_DN = 255


def picture(
    seed: int = 3, sigma: float = 4.0, *, brightest: float = 180.0, frames: int = 4
) -> np.ndarray:
    """A smooth picture with noise, as whole codes of three colours, (frames, 96, 128, 3)."""
    rng = np.random.default_rng(seed)
    ramp = np.linspace(20, brightest - 30, 128) + np.linspace(0, 30, 96)[:, None]
    codes = ramp[None, ..., None] + rng.normal(0, sigma, (frames, 96, 128, 3))
    return np.round(codes)


def counts(codes: np.ndarray) -> dict[str, np.ndarray]:
    dn = np.clip(np.round(codes), 0, TOP_DN).astype(np.uint8)
    return histograms([dn], SITES, TOP_DN)


@pytest.mark.parametrize(
    ("red", "blue"), [(1.2, 0.85), (1.6, 1.33), (1.0, 0.7), (1.45, 2.35), (2.6, 1.0)]
)
def test_gains_of_whole_codes_are_read_from_their_combs(red: float, blue: float) -> None:
    codes = counts(picture(frames=16) * np.array([red, 1.0, blue]))
    found = white_balance(codes)
    assert found is not None
    assert (found.red_gain, found.blue_gain, found.about_black) == (red, blue, 0.0)


def test_a_comb_tells_the_black_level_that_a_gain_leaves_alone() -> None:
    black = 7.0
    found = white_balance(counts(black + (picture() - black) * np.array([1.2, 1.0, 1.0])))
    assert found is not None
    assert found.red_gain == pytest.approx(1.2, abs=2e-3)
    assert found.about_black == 1.0


@pytest.mark.parametrize(("low", "high"), [(0, 800), (1600, 2400)])
def test_gains_of_finer_codes_are_read_where_each_colour_has_its_own(low: int, high: int) -> None:
    """12 bits: a comb stands wherever a colour's codes are, from zero on or far from it."""
    codes = np.random.default_rng(6).integers(low, high, (3, 500_000))
    gains = {"R": 1.3, "G": 1.0, "B": 0.85}
    counted = {
        name: np.bincount(np.rint(gain * own).astype(int), minlength=4096).astype(float)
        for (name, gain), own in zip(gains.items(), codes, strict=True)
    }
    found = white_balance(counted)
    assert found is not None
    assert (found.red_gain, found.blue_gain) == (1.3, 0.85)


@pytest.mark.parametrize("bits", [1, 2, 3])
def test_gains_of_codes_that_lost_bits_are_read_from_wider_combs(bits: int) -> None:
    """Of every second, fourth and eighth code, to what 150 codes tell. Green keeps its
    codes, and tells of the lost bits by itself."""
    step, black = 2**bits, 5.0
    codes = picture() // step * step
    balanced = np.rint(black + (codes - black) * np.array([1.06, 1.0, 0.87]))
    shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=0.01, frames=4)
    stack = Frames(dn=balanced.astype(np.uint8), shot=shot, pixels="rgb8", bits=8, cfa="RGGB")
    assert empty_bits([stack], SITES) == bits
    found = white_balance(counts(balanced), step)
    assert found is not None
    assert (found.red_gain, found.blue_gain) == pytest.approx((1.06, 0.87), abs=5e-3)
    assert white_balance(counts(codes), step) is None


def test_gains_before_the_converter_leave_no_comb() -> None:
    """The impostor: the same gains on the signal in fractions, or all colours in other steps."""
    rng = np.random.default_rng(5)
    signal = picture() + rng.uniform(-0.5, 0.5, picture().shape)
    assert white_balance(counts(signal * np.array([1.2, 1.0, 0.85]))) is None
    assert white_balance(counts(picture() // 4 * 4)) is None


@pytest.mark.parametrize(
    ("red", "blue"),
    [(1.006, 1.0101), (0.987, 1.018), (1.01, 1.0), (1.0314, 1.0524), (0.89, 0.945), (1.02, 1.11)],
)
@pytest.mark.parametrize("black_dn", [0.0, 4.3])
def test_gains_near_1_are_read_from_their_few_teeth(
    red: float, blue: float, black_dn: float
) -> None:
    """Code o + (k - 1/2) / (g - 1) is the k-th that is left out, or taken twice: of one at 54 half
    a code is a hundredth of g - 1, as half a DN is of the origin o."""
    codes = black_dn + (picture(brightest=250.0, frames=16) - black_dn) * np.array([red, 1.0, blue])
    ways = [one.white_balance for one in gains_by_teeth(counts(codes), black_dn + 0.2)]
    assert [one.about_black for one in ways] in ([1.0], [1.0, 0.0], [0.0, 1.0])
    found = next(one for one in ways if one.about_black == 1.0)
    off = np.array([found.red_gain - red, found.blue_gain - blue])
    assert np.all(np.abs(off) < 0.03 * np.abs(np.array([red, blue]) - 1.0) + 1e-9)


@pytest.mark.parametrize(("red", "blue"), [(1.0314, 1.0524), (0.89, 0.945), (1.02, 1.11)])
def test_many_teeth_tell_what_gains_leave_alone(red: float, blue: float) -> None:
    """The last of n teeth at code x moves by 1 / (g - 1) where the gain is 1 / x off."""
    black_dn = 4.3
    codes = black_dn + (picture(brightest=250.0, frames=16) - black_dn) * np.array([red, 1.0, blue])
    (found,) = gains_by_teeth(counts(codes), black_dn + 0.3)
    balance = found.white_balance
    assert (balance.red_gain, balance.blue_gain) == pytest.approx((red, blue), abs=6e-4)
    assert balance.about_black == 1.0
    assert found.origin_dn == pytest.approx(black_dn, abs=0.35)


@pytest.mark.parametrize("seed", range(8))
def test_other_cameras_have_no_gains_near_1(seed: int) -> None:
    """Neither one without gains, nor one whose codes are all bent, or of unequal width."""
    codes = picture(seed)
    assert gains_by_teeth(counts(codes), 4.3) == ()
    assert gains_by_teeth(counts(powered(codes, 255.0, 0.0, 0.98)), 0.0) == ()
    alike = 4.3 + (codes - 4.3) * 1.01
    assert gains_by_teeth(counts(alike), 4.3) == ()
    unequal = np.where(codes % 64 == 63, codes + np.array([1.0, 0.0, 0.0]), codes)
    assert gains_by_teeth(counts(unequal), 4.3) == ()


@pytest.mark.parametrize("seed", range(6, 12))
def test_teeth_of_a_chart_are_no_comb(seed: int) -> None:
    """50 codes, each as frequent as chance has it: of so many gains one is always like them. By
    0.57 alone seed 8 had a blue gain of 0.775."""
    rng = np.random.default_rng(seed)
    uneven = {channel: np.zeros(TOP_DN + 1) for channel in "RGB"}
    for one in uneven.values():
        one[20:70] = 2000 * (1 + 0.6 * rng.standard_normal(50).clip(-1, 1))
    assert white_balance(uneven) is None


@pytest.mark.parametrize("power", [0.8, 0.9])
@pytest.mark.parametrize("black_dn", [0.0, 4.3])
def test_the_exponent_of_whole_codes_is_read_from_their_comb(power: float, black_dn: float) -> None:
    """About code 0 or about a black level, of which the frames tell half a code less."""
    found = curve(counts(powered(picture(), TOP_DN, black_dn, power)), black_dn - 0.5)
    assert found is not None
    assert found.exponent == pytest.approx(power, abs=3e-3)
    assert found.origin_dn == pytest.approx(black_dn, abs=0.6)
    assert bool(found.origin_dn) == bool(black_dn)


@pytest.mark.parametrize("power", [0.9725, 0.985, 1.015])
@pytest.mark.parametrize("black_dn", [0.0, 4.3])
def test_a_power_that_is_nearly_straight_is_read_from_a_few_teeth(
    power: float, black_dn: float
) -> None:
    """Code n comes out n (1 - g) |log x| higher, at most by 2.6 codes at 0.9725: some teeth on
    either side of 0.37 of the range. Half a code of origin, of those 2.6, is a fifth of 1 - g."""
    codes = powered(picture(brightest=250.0, frames=16), TOP_DN, black_dn, power)
    found = nearly_straight(counts(codes), black_dn - 0.2)
    assert found is not None
    assert not found.sharp
    assert found.exponent == pytest.approx(power, abs=0.2 * abs(1 - power))


def test_what_channels_do_not_share_is_no_power() -> None:
    """Gains near 1 leave out a code in red and take one twice in blue; whole codes do neither."""
    assert nearly_straight(counts(picture()), 4.3) is None
    gains = np.array([1.02, 1.0, 0.97])
    assert nearly_straight(counts(picture() * gains), 4.3) is None


def test_whole_codes_and_a_dark_have_no_curve() -> None:
    """A dark is a narrow tooth by itself: curves that are flat at black have one there."""
    assert curve(counts(picture()), 4.3) is None
    darks = np.random.default_rng(4).normal(4.3, 0.6, picture().shape)
    assert curve(counts(np.concatenate([picture(), darks])), 4.3) is None


@pytest.mark.parametrize("bits", [0, 1, 2])
def test_bits_that_were_never_counted_in(bits: int) -> None:
    shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=0.01, frames=4)
    dn = (picture() // 2**bits * 2**bits).astype(np.uint8)
    stack = Frames(dn=dn, shot=shot, pixels="rgb8", bits=8, cfa="RGGB")
    assert empty_bits([stack], SITES) == bits
    dn[:, ::9] = 255  # clipped at either end
    dn[:, 1::9] = 0
    assert empty_bits([stack], SITES) == bits


def test_the_dwell_time_of_traps_is_read_from_the_noisiest_pixels() -> None:
    """Of two levels that last equally long, among noise and in noise alone."""
    rng, dwell, interval = np.random.default_rng(8), 0.2, 0.05
    noise = rng.normal(0, 2, (40, 96, 128, 3))
    # looked at after each interval, a chain of two levels has changed an odd number of times
    jumps = rng.random((40, 400)) < 0.5 * (1 - np.exp(-2 * interval / dwell))
    traps = 20 * (np.cumsum(jumps, axis=0) % 2)
    down, across = rng.integers(0, 96, 400), rng.integers(0, 128, 400)
    trapped = noise.copy()
    trapped[:, down, across] += traps[..., None]

    def told(frames: np.ndarray) -> float | None:
        shot = Shot(label="dark", exposure_s=0.01, frames=40, interval_s=interval)
        dn = np.clip(np.round(50 + frames), 0, TOP_DN).astype(np.uint8)
        return dwell_s([Frames(dn=dn, shot=shot, pixels="rgb8", bits=8, cfa="RGGB")], SITES)

    assert told(trapped) == pytest.approx(dwell, rel=0.3)
    assert told(noise) is None


def compressed(codes: np.ndarray, quality: int) -> np.ndarray:
    """Frames written as JPEG and read again, by the codec itself."""
    out = []
    for frame in np.clip(np.round(codes), 0, TOP_DN).astype(np.uint8):
        packed = io.BytesIO()
        Image.fromarray(frame).save(packed, "JPEG", quality=quality)
        out.append(np.asarray(Image.open(packed)))
    return np.stack(out)


@pytest.mark.parametrize(("quality", "sigma"), [(100, 4.0), (97, 4.0), (75, 4.0), (40, 20.0)])
def test_the_quality_of_jpeg_is_read_from_the_combs_of_its_coefficients(
    quality: int, sigma: float
) -> None:
    codes = picture(sigma=sigma)
    assert jpeg_tables.quality([compressed(codes, quality)]) == quality
    assert jpeg_tables.quality([compressed(codes[..., 1], quality)]) == quality


def test_frames_that_never_were_jpeg_have_no_quality() -> None:
    """Impostors: plain codes, lost bits, a blur, a grid that begins elsewhere."""
    blurred = ndimage.gaussian_filter(picture(), (0, 1, 1, 0))
    elsewhere = compressed(picture(), 75)[:, 3:, 5:]
    for impostor in (picture(), picture() // 4 * 4, blurred, elsewhere):
        codes = np.clip(np.round(impostor), 0, TOP_DN).astype(np.uint8)
        assert jpeg_tables.quality([codes]) is None
    assert jpeg_tables.quality([]) is None


def sent(
    mode: int, taken: int = 0, drawn: int = 0, rows: int = 1, *, blur: float = 0.0
) -> np.ndarray:
    """A mosaic's noise, filled in and sent with one colour for several pixels, or blurred."""
    codes = picture()
    codes[..., 0] = (codes[..., 0] + np.roll(codes[..., 0], 1, axis=2)) / 2
    if mode:
        effect = ChromaSubsampling(mode=mode, whole_codes=0, taken=taken, drawn=drawn, rows=rows)
        return applied(effect, codes).astype(np.uint8)
    grey = codes.mean(axis=-1, keepdims=True)
    colours = ndimage.gaussian_filter1d(codes - grey, blur, axis=2) if blur else codes - grey
    return np.clip(np.round(grey + colours), 0, TOP_DN).astype(np.uint8)


@pytest.mark.parametrize(("mode", "rows"), [(1, 1), (2, 1), (1, 2)])
@pytest.mark.parametrize(("taken", "drawn"), [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1),
                                               (0, 2), (1, 2)])  # fmt: skip
def test_how_many_pixels_share_a_colour_is_read(
    mode: int, rows: int, taken: int, drawn: int
) -> None:
    expected = {"mode": mode, "drawn": drawn, "rows": rows}
    found = shared_colours([sent(mode, taken, drawn, rows)])
    assert found == expected | ({"taken": min(taken, 1)} if drawn else {})


@pytest.mark.parametrize("mode", [1, 2])
def test_shared_colours_are_read_where_some_codes_are_clipped(mode: int) -> None:
    """A pure yellow has no blue: what is shown of it is black where the noise of its luma is below,
    which is no sum of luma and colours, and off by more than any rounding."""
    codes = picture(sigma=12.0)
    codes[..., 2] *= 0.1
    shown = applied(ChromaSubsampling(mode=mode, whole_codes=0), codes).clip(0, TOP_DN)
    assert 0.01 < (shown == 0).mean() < 0.1
    found = shared_colours([shown.astype(np.uint8)])
    assert found == {"mode": mode, "drawn": 0, "rows": 1}


@pytest.mark.parametrize("blur", [0.0, 0.7, 1.5, 3.0])
def test_colours_that_are_blurred_are_not_shared(blur: float) -> None:
    """Nor are those of few pixels, or none."""
    assert shared_colours([sent(0, blur=blur)]) is None
    assert shared_colours([sent(1)[:, :, :40]]) is None
    assert shared_colours([sent(1)[..., 0], np.full((4, 64, 64, 3), 17, dtype=np.uint8)]) is None
