"""Order: the closed forms of the camera notice when neighbours along the signal path change places.

A camera refuses effects out of order; here the refusal is circumvented, as a fault in its order
would, and the same check that the true camera passes must fail.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.crosstalk import Crosstalk
from sensor.effects.dark_shot import DarkShot
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.gamma import Gamma
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.prnu import Prnu
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.effects.smear import Smear
from sensor.errors import CameraError
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate
from tests.harness import assert_agree, variance_error

SIDE, FRAMES, GAIN, BLACK = 96, 24, 0.5, 100.0
EXPOSURE_S = 0.02
DARK_E = 2000.0
DARK_CURRENT = DARK_E / EXPOSURE_S
PIXELS = SIDE * SIDE
SAMPLES = (FRAMES - 1) * PIXELS
READ = ReadNoise(reset_e=0.0, thermal_e=40.0, other_e=0.0)
QUIET = ReadNoise(reset_e=0.0, thermal_e=4.0, other_e=0.0)

Array = np.ndarray


def camera(*effects: Effect) -> Camera:
    plain = Camera(
        name="order",
        width=SIDE,
        height=SIDE,
        pixels="rgb8",
        bits=8,
        gain_dn_per_e=Colours.of(GAIN),
        black_dn=BLACK,
    )
    return plain.plus(*effects)


def swapped(right: Camera, first: type[Effect], second: type[Effect]) -> Camera:
    """The camera with two effects in each other's place, which no camera file can ask for."""
    names = [type(effect) for effect in right.effects]
    effects = list(right.effects)
    a, b = names.index(first), names.index(second)
    effects[a], effects[b] = effects[b], effects[a]
    wrong = copy.copy(right)
    object.__setattr__(wrong, "effects", tuple(effects))
    return wrong


def dn(of: Camera, electrons: float | Array) -> Array:
    """Unrounded DN of frames lit so that each pixel collects so many electrons in the mean."""
    rate = np.broadcast_to(np.asarray(electrons, np.float32) / EXPOSURE_S, (SIDE, SIDE))
    light = {"lamp": np.repeat(rate[..., None], 3, axis=2).astype(np.float32)}
    lit = bool(rate.any())
    shot = Shot(
        label="lit", light=("lamp" if lit else "none",), exposure_s=EXPOSURE_S, frames=FRAMES
    )
    return simulate(of, shot, light, until=Quantity.DN).numpy().astype(float)


def dark_charge_has_no_share_of_prnu(of: Camera) -> None:
    """Dark electrons come from no light: their mean is the same in all photosites."""
    frames = dn(of, 0.0)
    pattern = frames.mean(0).var(ddof=1) - frames.var(0, ddof=1).mean() / FRAMES
    error = variance_error(GAIN**2 * DARK_E / FRAMES, PIXELS)
    assert_agree(pattern, 0.0, error, "spatial variance in the dark")


def dark_charge_has_shot_noise(of: Camera) -> None:
    variance = GAIN**2 * DARK_E
    got = dn(of, 0.0).var(0, ddof=1).mean()
    assert_agree(got, variance, variance_error(variance, SAMPLES), "variance in the dark")


def offsets_bring_no_shot_noise(of: Camera) -> None:
    """A photosite's temporal variance does not depend on its offset."""
    frames = dn(of, 0.0)
    offset = frames.mean(0) - frames.mean()
    variance = frames.var(0, ddof=1)
    slope = (offset * variance).mean() / offset.var()
    error = variance.std() / offset.std() / math.sqrt(PIXELS)
    # mean and variance of a Poisson count are correlated: k3 / n / var(offset), k3 = g^3 mean
    expected = GAIN**3 * DARK_E / FRAMES / offset.var()
    assert_agree(slope, expected, error, "variance against offset")


def read_noise_is_averaged_by_the_demosaicer(of: Camera) -> None:
    variance = (GAIN * 40.0) ** 2 * np.array([0.5625, 0.625, 0.5625])
    got = dn(of, 0.0).var(0, ddof=1).mean((0, 1))
    # of the interpolated samples of a colour, those that were measured are independent
    error = variance_error((GAIN * 40.0) ** 2, (FRAMES - 1) * PIXELS / 4)
    assert_agree(got, variance, error, "variance by colour")


def rounding_brings_no_bias(of: Camera) -> None:
    """Means of whole codes are not whole: what rounds before they are taken loses the rest."""
    rate = np.full((SIDE, SIDE, 3), 40.0 / EXPOSURE_S, np.float32)
    shot = Shot(label="lit", light=("lamp",), exposure_s=EXPOSURE_S, frames=FRAMES)
    codes = pixels_of(of, simulate(of, shot, {"lamp": rate})).astype(float)
    sigma = math.sqrt((GAIN * QUIET.thermal_e) ** 2 + 1 / 12)
    error = sigma / math.sqrt(FRAMES * PIXELS / 4)
    assert_agree(codes.mean((0, 1, 2)), GAIN * 40.0 + BLACK, error, "mean by colour")


def charge_that_crosses_over_stays_independent(of: Camera) -> None:
    frames = dn(of, 5000.0)
    left = frames - frames.mean(0)
    variance = GAIN**2 * 5000.0 * (FRAMES - 1) / FRAMES
    products = [(left[:, :, 1:] * left[:, :, :-1]).mean(), (left[:, 1:] * left[:, :-1]).mean()]
    # products of independent numbers; the FRAMES - 1 are what the mean over frames leaves
    error = variance / math.sqrt((FRAMES - 1) * SIDE * (SIDE - 1))
    assert_agree(products, [0, 0], error, "covariance of neighbours")


def smeared_charge_is_drawn_once(of: Camera) -> None:
    """In the dark rows of a lit column: mean and variance are both the smear."""
    light = np.zeros((SIDE, SIDE))
    light[: SIDE // 2] = 20_000.0
    below = dn(of, light)[:, SIDE // 2 + 8 :]
    smear_e = 0.05 / EXPOSURE_S / 15 * light.mean()
    n = below[0].size
    assert_agree(
        [below.mean() - BLACK, below.var(0, ddof=1).mean()],
        [GAIN * smear_e, GAIN**2 * smear_e],
        [
            # the smear of a column is one draw of its light in each frame: its rows share that
            GAIN * math.sqrt(smear_e / below.size) * 2,
            variance_error(GAIN**2 * smear_e, (FRAMES - 1) * n) * 1.1,
        ],
        "smear",
    )


def the_curve_bends_what_was_interpolated(of: Camera) -> None:
    """Green at a red photosite, rows bright and dim by turns: the curve of their mean."""
    bright, dim = 250.0, 20.0
    rows = np.where(np.arange(SIDE) % 2 == 0, bright, dim)[:, None] * np.ones(SIDE)
    at_red = dn(of, rows)[0, 2:-2:2, 2:-2:2, 1]
    span = 255 - BLACK
    mean_of_both = GAIN * (bright + dim) / 2 / span
    expected = BLACK + span * mean_of_both**0.5
    assert_agree(at_red, expected, 1e-3 / 3, "the curve of the mean")


@dataclass(frozen=True, kw_only=True)
class Case:
    """Two neighbours, a camera in which their order matters, and the check that shows it."""

    pair: tuple[type[Effect], type[Effect]]
    effects: tuple[Effect, ...]
    check: Callable[[Camera], None]


CASES = [
    Case(
        pair=(Prnu, DarkShot),
        effects=(Prnu(ratio=0.05), DarkShot(current_e_per_s=DARK_CURRENT), PhotonShot()),
        check=dark_charge_has_no_share_of_prnu,
    ),
    Case(
        pair=(DarkShot, PhotonShot),
        effects=(DarkShot(current_e_per_s=DARK_CURRENT), PhotonShot()),
        check=dark_charge_has_shot_noise,
    ),
    Case(
        pair=(PhotonShot, Fpn),
        effects=(DarkShot(current_e_per_s=DARK_CURRENT), PhotonShot(), Fpn(sigma_e=200.0)),
        check=offsets_bring_no_shot_noise,
    ),
    Case(
        pair=(ReadNoise, Demosaic),
        effects=(READ, Demosaic()),
        check=read_noise_is_averaged_by_the_demosaicer,
    ),
    Case(
        pair=(Demosaic, Quantization),
        effects=(QUIET, Demosaic(), Quantization()),
        check=rounding_brings_no_bias,
    ),
    Case(
        pair=(Crosstalk, PhotonShot),
        effects=(Crosstalk(share=0.2), PhotonShot()),
        check=charge_that_crosses_over_stays_independent,
    ),
    Case(
        pair=(PhotonShot, Smear),
        effects=(PhotonShot(), Smear(leak_ratio=0.05)),
        check=smeared_charge_is_drawn_once,
    ),
    Case(
        pair=(Demosaic, Gamma),
        effects=(Demosaic(), Gamma(exponent=0.5)),
        check=the_curve_bends_what_was_interpolated,
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda c: f"{c.pair[0].name}-{c.pair[1].name}")
def test_neighbours_that_change_places_are_noticed(case: Case) -> None:
    right = camera(*case.effects)
    wrong = swapped(right, *case.pair)
    with pytest.raises(CameraError, match="comes first"):
        Camera(**{**vars(right), "effects": wrong.effects})
    case.check(right)
    with pytest.raises(AssertionError):
        case.check(wrong)


def test_the_one_pair_that_may_change_places_is_a_sum() -> None:
    """Offsets and read noise are added to the same charge: no statistic can tell their order."""
    right = camera(Fpn(sigma_e=50.0), READ)
    wrong = swapped(right, Fpn, ReadNoise)
    assert np.allclose(dn(right, 1000.0), dn(wrong, 1000.0), atol=1e-3)


def test_every_pair_of_neighbours_of_the_base_camera_is_covered() -> None:
    base = (Prnu, DarkShot, PhotonShot, Fpn, ReadNoise, Demosaic, Quantization)
    covered = {case.pair for case in CASES} | {(Fpn, ReadNoise)}
    assert set(pairwise(base)) <= covered
