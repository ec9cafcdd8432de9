"""Where codes end, and what gains behind finer codes that tells."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.look.code_edges import CodeEdges, code_edges
from analysis.gap.look.finer_codes import FinerCodes, finer_codes, in_turn
from analysis.gap.look.finer_gains import comb, finer_gains
from analysis.gap.look.lattices import Lattice
from sensor.frames import Frames
from sensor.protocol import Shot

CHANNELS = tuple(Lattice(name=c, channel=c, dy=0, dx=0, step=1) for c in "RGB")
BLACK_DN = 4.2
GAIN_DN_PER_E = 0.02
READ_DN = 0.8
LOUD = (0.032, 1.0)
"""The same two of a camera whose combs are told less well."""
FRAMES = 24
EDGES = 257


def signal(
    seed: int,
    *,
    dark: bool = False,
    gain_dn_per_e: float = GAIN_DN_PER_E,
    read_dn: float = READ_DN,
    part: float = 1.0,
) -> np.ndarray:
    """What is in front of the converter, in codes, (frames, 96, 128, 3): a picture with
    gradients, a pattern of its own, and the noise of photons, at a part of its light.
    """
    rng = np.random.default_rng(seed)
    ramp = part * (np.linspace(0, 160, 128) + np.linspace(0, 40, 96)[:, None])
    level = np.zeros((96, 128, 3)) if dark else ramp[..., None] * np.array([1.0, 1.1, 0.8])
    level = level * (1 + 0.01 * rng.standard_normal(level.shape))
    sigma = np.sqrt(gain_dn_per_e * np.maximum(level, 0) + read_dn**2)
    return BLACK_DN + level + sigma * rng.standard_normal((FRAMES, *level.shape))


def edges_of(*codes: np.ndarray) -> dict[str, CodeEdges]:
    """Of some shots, the first of which is dark."""
    shots = [
        Frames(
            dn=np.clip(dn, 0, 255).astype(np.uint8),
            shot=Shot(
                label=f"shot {k}",
                light=("lamp",) if k else (),
                level=(1.0,) if k else (),
                exposure_s=0.01,
                frames=len(dn),
            ),
            pixels="rgb8",
            bits=8,
            cfa=None,
        )
        for k, dn in enumerate(codes)
    ]
    return {c: code_edges(shots, CHANNELS, c) for c in "RGB"}


def up(codes: np.ndarray) -> np.ndarray:
    return np.asarray(np.floor(codes + 0.5))


def balanced(codes: np.ndarray, red: float, blue: float, origin_dn: float) -> np.ndarray:
    return np.asarray(origin_dn + (codes - origin_dn) * np.array([red, 1.0, blue]))


def taken(seed: int, steps: float, red: float, blue: float, origin_dn: float) -> FinerCodes | None:
    """What two shots of a camera with finer codes and gains behind them tell."""
    shots = [signal(seed, dark=True), signal(seed + 1)]
    return finer_codes(
        edges_of(*(up(balanced(up(s * steps) / steps, red, blue, origin_dn)) for s in shots)),
        BLACK_DN + 0.05,
    )


@pytest.mark.parametrize("seed", range(3))
def test_an_edge_that_lies_elsewhere_has_its_place_and_its_error(seed: int) -> None:
    """Codes 60 and 90 end 0.1 and -0.05 codes from where they should: d is (d M d)^-1 p, to
    (d M d)^-1/2; beyond five standard errors it would be once in two million times.
    """
    codes = signal(seed)
    moved = up(codes)
    moved[(codes >= 60.5) & (codes < 60.6)] = 60
    moved[(codes >= 90.45) & (codes < 90.5)] = 91
    for own in edges_of(moved).values():
        place = 0.1 * (own.codes == 61) - 0.05 * (own.codes == 91)
        power = float(place @ own.information @ place)
        assert power > 25.0
        assert float(place @ own.pull) / power == pytest.approx(1.0, abs=5.0 / np.sqrt(power))


@pytest.mark.parametrize("part", [1.0, 1 / 3])
def test_edges_that_are_farther_off_than_they_should_be_are_told(part: float) -> None:
    """Edges d that are there leave a chi-squared of one to any other scale; where a part s of them
    is expected, P becomes s^2 P and x is s P: (1 / s - 1)^2 s^2 P = (1 - s)^2 P is left, whose root
    has a standard error of 1."""
    codes = signal(7)
    moved = up(codes)
    moved[(codes >= 60.5) & (codes < 60.8)] = 60
    moved[(codes >= 90.2) & (codes < 90.5)] = 91
    for own in edges_of(moved).values():
        place = 0.3 * (own.codes == 61) - 0.3 * (own.codes == 91)
        power = float(place @ own.information @ place)
        assert power > 300.0
        root = np.sqrt(own.off_scale(part * place))
        assert root == pytest.approx((1 - part) * np.sqrt(power), abs=4.5)


@pytest.mark.parametrize("part", [0.1, 0.3, 1.0])
def test_edges_that_wander_slowly_are_as_far_off_as_they_are(part: float) -> None:
    """A gain of 0.9312 behind sixteenths moves edges in turns of five and a half codes. Means of
    pixels and the noise of dim pictures go along: with what they do, the comb is there once, to
    five of its own standard errors; without it 0.38, 0.59 and 0.90 times."""
    gain, along, power = 0.9312, 0.0, 0.0
    for seed in range(8):
        codes = signal(50 + seed, part=part, read_dn=0.6)
        edges = edges_of(up(balanced(up(codes * 16) / 16, gain, gain, BLACK_DN)))
        for own in (edges["R"], edges["B"]):
            (teeth,) = comb(np.array([gain]), np.array([BLACK_DN]), 16.0, own.codes)
            along += float(teeth @ own.pull)
            power += float(teeth @ own.information @ teeth)
    assert along / power == pytest.approx(1.0, abs=5.0 / np.sqrt(power))


@pytest.mark.parametrize("seed", range(3))
def test_codes_that_are_equally_wide_leave_chance_alone(seed: int) -> None:
    """A picture with a pattern and a gradient, and no counting error: chi-squared of n figures is
    below n + 5 sqrt(2 n). Counts of the same pixels scatter less than those of Poisson."""
    for own in edges_of(up(signal(seed, dark=True)), up(signal(seed + 10))).values():
        assert own.chi2 < own.figures + 5.0 * np.sqrt(2.0 * own.figures)
        assert own.chi2 > 0.5 * own.figures


def test_a_few_pixels_that_are_louder_than_others_take_no_part() -> None:
    """One in a hundred jumps up by ten codes and back: a mean over the frames is then between both.
    Without them chance is all there is, to five of its standard errors; with them chi-squared is
    beyond any."""
    codes = [signal(0, dark=True), signal(10)]
    rng = np.random.default_rng(5)
    for one in codes:
        jumps = rng.random(one.shape[1:]) < 0.01
        one += 10.0 * jumps * (rng.random(one.shape) < 0.4)
    for own in edges_of(*map(up, codes)).values():
        assert own.chi2 < own.figures + 5.0 * np.sqrt(2.0 * own.figures)


def test_noise_grows_with_the_mean_by_the_gain() -> None:
    """To five of its own standard errors, which are those of variances of so many samples."""
    for own in edges_of(up(signal(3, dark=True)), up(signal(4))).values():
        error = own.slope_error * GAIN_DN_PER_E
        assert own.noise_slope_dn == pytest.approx(GAIN_DN_PER_E, abs=5.0 * error)
        assert own.slope_error < 0.03


def test_shots_that_tell_nothing_change_nothing() -> None:
    """One that is saturated all over, and one of a single frame."""
    shots = [up(signal(3, dark=True)), up(signal(4))]
    more = [*shots, np.full_like(shots[0], 255.0), shots[1][:1]]
    for alone, own in zip(edges_of(*shots).values(), edges_of(*more).values(), strict=True):
        assert own.figures == alone.figures
        assert own.pull == pytest.approx(alone.pull)
        assert own.noise_slope_dn == pytest.approx(alone.noise_slope_dn)


@pytest.mark.parametrize("steps", [4.0, 16.0])
@pytest.mark.parametrize("gain", [0.87, 1.2038, 1.7])
def test_a_comb_has_the_edges_of_every_step_that_is_counted(steps: float, gain: float) -> None:
    """Step after step through the camera: an edge is half a step in front of a code's first."""
    out = BLACK_DN + gain * (np.arange(int(steps * 400)) / steps - BLACK_DN)
    code = up(out)
    first = np.array([out[np.argmax(code >= n)] for n in range(6, EDGES)])
    edge = first - gain / steps / 2.0 - (np.arange(6, EDGES) - 0.5)
    (found,) = comb(np.array([gain]), np.array([BLACK_DN]), steps, np.arange(6, EDGES))
    assert found == pytest.approx(edge, abs=1e-9)


@pytest.mark.parametrize(("steps", "red", "blue"), [(4.0, 1.2038, 0.871), (16.0, 1.1213, 0.93)])
@pytest.mark.parametrize("about_black", [True, False])
def test_gains_behind_finer_codes_are_read(
    steps: float, red: float, blue: float, about_black: bool
) -> None:
    """To what moves a tooth by a tenth of a step over 150 codes."""
    found = taken(7, steps, red, blue, BLACK_DN if about_black else 0.0)
    assert found is not None
    assert found.rules == ((9, 10) if steps == 4 else (6, 7))
    gains = found.gains[0].white_balance
    assert (gains.red_gain, gains.blue_gain) == pytest.approx((red, blue), abs=0.1 / steps / 15)
    assert gains.about_black == float(about_black)


@pytest.mark.parametrize("seed", [17, 40, 110])
def test_no_gains_are_missed_that_are_likelier(seed: int) -> None:
    """The true ones, of which one colour has likelier ones about an origin that the other rules
    out: what is found makes chi-squared as small, and they are among it. So it is in 39 of the 40
    seeds from 100 on."""
    gains = np.exp(np.random.default_rng(seed).uniform(np.log(0.85), np.log(1.18), 2))
    shots = [signal(seed + k, dark=not k, gain_dn_per_e=LOUD[0], read_dn=LOUD[1]) for k in range(2)]
    edges = edges_of(*(up(balanced(up(s * 16) / 16, *gains, BLACK_DN)) for s in shots))
    true = sum(
        float(edges[c].fall(comb(np.array([k]), np.array([BLACK_DN]), 16.0, edges[c].codes))[0])
        for c, k in zip("RB", gains, strict=True)
    )
    found = finer_gains(edges, 16.0, BLACK_DN + 0.05, least_power=0.0)
    assert sum(found[0].falls) > true - 0.5
    likely = [(one.white_balance.red_gain, one.white_balance.blue_gain) for one in found]
    assert any(pair == pytest.approx(tuple(gains), abs=5e-5) for pair in likely)


@pytest.mark.whole
@pytest.mark.parametrize("seed", range(20, 22))
def test_other_cameras_have_no_gains_behind_finer_codes(seed: int) -> None:
    """Gains in front of the converter, behind whole codes, and codes that are wide and narrow in
    turn without a gain."""
    gains = np.array([1.12, 1.0, 0.93])
    shots = [signal(seed, dark=True), signal(seed + 1)]
    for counted in (
        [up(s * gains) for s in shots],
        [up(balanced(up(s), 1.12, 0.93, 0.0)) for s in shots],
        [np.rint(up(s * 16) / 16) for s in shots],
    ):
        assert finer_codes(edges_of(*counted), BLACK_DN) is None


@pytest.mark.parametrize(("steps", "rule"), [(4, 8), (16, 5), (64, 11)])
def test_codes_that_are_wide_and_narrow_in_turn_are_told(steps: int, rule: int) -> None:
    """Even codes are wider by one step: by 1/64 behind 14 bits. Where halves go up none is."""
    shots = [signal(30 + k, dark=not k) for k in range(4)]
    found = in_turn(edges_of(*(np.rint(up(s * steps) / steps) for s in shots)))
    assert found is not None
    assert found.rules == (rule,)
    assert in_turn(edges_of(*(up(up(s * steps) / steps) for s in shots))) is None
