"""The camera: order, equation (1), and its moments."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import drjit as dr
import numpy as np
import pytest

from foundation.backend import backend
from sensor.camera_file import load, preset_names
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.blooming import Blooming
from sensor.effects.dark_shot import DarkShot
from sensor.effects.fpn import Fpn
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.prnu import Prnu
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.errors import CameraError
from sensor.protocol import Protocol, Shot
from sensor.simulation import pixels_of, simulate, stream_of
from sensor.truth import population, realised
from tests.backends import BACKENDS
from tests.harness import assert_agree, variance_error
from tests.plain_camera import GAIN, LIT, RATE, SIDE, camera, dark_shot, dn, rates


@pytest.mark.parametrize("where", BACKENDS)
def test_equation_one_term_by_term(where: str) -> None:
    """Temporal variance g^2 (I + d t + r^2), spatial variance g^2 (f^2 + p^2 I^2), mean g I + b."""
    light, dark_e = RATE * 0.01, 40_000 * 0.01
    fpn, read, ratio = 30.0, ReadNoise(reset_e=12, thermal_e=9, other_e=8), 0.02
    cam = camera(
        Prnu(ratio=ratio),
        DarkShot(current_e_per_s=40_000),
        PhotonShot(),
        Fpn(sigma_e=fpn),
        read,
    )
    frames = dn(cam, where)
    read_variance = 12**2 + 9**2 + 8**2
    temporal = GAIN**2 * (light + dark_e + read_variance)
    spatial = GAIN**2 * (fpn**2 + (ratio * light) ** 2)
    n, pixels = frames.shape[0], SIDE * SIDE
    mean_image = frames.mean(0)
    measured_spatial = mean_image.var(ddof=1) - temporal / n
    mean_error = math.sqrt((spatial + temporal / n) / pixels)
    assert_agree(
        [frames.mean(), frames.var(0, ddof=1).mean(), measured_spatial],
        [GAIN * light + 100.0, temporal, spatial],
        [
            mean_error,
            variance_error(temporal, (n - 1) * pixels + 1),
            variance_error(spatial + temporal / n, pixels),
        ],
    )


@pytest.mark.parametrize("where", BACKENDS)
def test_read_noise_parts_add_in_quadrature_and_differ_by_colour(where: str) -> None:
    thermal = Colours(R=3.0, G=10.0, B=30.0)
    frames = dn(camera(ReadNoise(reset_e=4.0, thermal_e=thermal, other_e=0.0)), where)
    sites = {"R": frames[:, ::2, ::2], "G": frames[:, ::2, 1::2], "B": frames[:, 1::2, 1::2]}
    for channel, values in sites.items():
        expected = GAIN**2 * (16 + thermal[channel] ** 2)
        got = values.var(0, ddof=1).mean()
        assert_agree(got, expected, variance_error(expected, values.size), channel)


def test_the_clamp_takes_off_the_mean_of_the_dark_charge_and_not_its_noise() -> None:
    frames = dn(camera(DarkShot(current_e_per_s=1e5), PhotonShot()), shot=dark_shot())
    expected = GAIN**2 * 1e5 * 0.01
    assert_agree(frames.mean(), 100.0, math.sqrt(expected / frames.size))
    assert_agree(frames.var(0, ddof=1).mean(), expected, variance_error(expected, frames.size))


@pytest.mark.parametrize("where", BACKENDS)
def test_the_clamp_has_the_noise_of_the_black_pixels_that_it_averages(where: str) -> None:
    """Means of frames have the variance g^2 (c^2 + s^2 / n); independent noise of the same size in
    each pixel averages out."""
    clamp_e, sigma_e = 3.0, 10.0

    def figures(effect: ReadNoise) -> tuple[float, float, float]:
        shot = Shot(label="dark", exposure_s=0.01, frames=400)
        means = dn(camera(effect), where, shot).mean((1, 2))
        expected = GAIN**2 * (clamp_e**2 + sigma_e**2 / SIDE**2)
        return means.var(ddof=1), expected, variance_error(expected, len(means))

    assert_agree(*figures(ReadNoise(reset_e=0, thermal_e=sigma_e, other_e=0, clamp_e=clamp_e)))
    got, expected, error = figures(ReadNoise(reset_e=0, thermal_e=sigma_e, other_e=clamp_e))
    assert expected - got > 10 * error


def test_body_patterns_are_the_same_in_every_shot_and_other_in_another_body() -> None:
    cam = camera(Fpn(sigma_e=50))
    lit, dark = dn(cam)[0], dn(cam, shot=dark_shot())[0]
    assert np.allclose(lit - lit.mean(), dark - dark.mean(), atol=1e-3)
    assert abs(np.corrcoef(lit.ravel(), dn(cam.with_body(1))[0].ravel())[0, 1]) < 5 / SIDE


def test_adding_an_effect_leaves_the_draws_of_the_others_alone() -> None:
    alone = dn(camera(ReadNoise()))
    both = dn(camera(ReadNoise(), Fpn(sigma_e=50)))
    pattern = both - alone
    assert np.allclose(pattern, pattern[0], atol=2e-3)


def test_the_truth_of_dsnu_has_both_patterns_at_the_longest_exposure() -> None:
    """hypot of offsets and of spread x t: of the make exactly, of this body as its frames are."""
    cam = camera(
        Fpn(sigma_e=30), DarkShot(current_e_per_s=9000.0, spread_e_per_s=1000.0), body_seed=5
    )
    assert population(cam, 0.04)["G"]["dsnu"] == pytest.approx(GAIN * 50.0)
    assert population(cam, 0.0)["G"]["dsnu"] == pytest.approx(GAIN * 30.0)
    frame = dn(cam, shot=dataclasses.replace(dark_shot(), exposure_s=0.04, frames=1))[0]
    own = realised(cam, 0.04, Protocol(name="one", shot=(dark_shot(),)), backend())
    greens = frame[cam.format.colour_index == 1]
    # the two patterns are independent: their product has the deviation 2 x 30 x 40 / sqrt(n)
    error = GAIN**2 * 2 * 30 * 40 / np.sqrt(greens.size)
    assert_agree(greens.var(), own["G"]["dsnu"] ** 2, error)


def test_the_part_of_dark_current_that_is_shown_moves_the_mean_and_nothing_else() -> None:
    """gain x shown x t in the mean, and the variance of the whole dark charge as before."""
    seen = {}
    for shown in (0.0, 3000.0):
        cam = camera(DarkShot(current_e_per_s=5000.0, shown_e_per_s=shown), PhotonShot())
        seen[shown] = dn(cam, shot=dataclasses.replace(LIT, light=("none",), exposure_s=0.1))
    moved = seen[3000.0] - seen[0.0]
    assert np.allclose(moved, GAIN * 300.0, atol=1e-3)


def test_dark_current_differs_between_photosites_and_its_pattern_grows_with_the_exposure() -> None:
    """The same pattern in every shot, of standard deviation gain x spread x t; fixed offsets of one
    exposure's size are as large in the other."""
    spread, n = 500.0, SIDE * SIDE
    cam = camera(DarkShot(current_e_per_s=9000.0, spread_e_per_s=spread))
    shots = [dataclasses.replace(dark_shot(), exposure_s=t, frames=1) for t in (0.01, 0.04)]
    short, long = (dn(cam, shot=shot)[0] - 100.0 for shot in shots)
    assert np.allclose(long, 4 * short, atol=1e-3)
    for pattern, exposure_s in ((short, 0.01), (long, 0.04)):
        expected = (GAIN * spread * exposure_s) ** 2
        assert_agree(pattern.var(), expected, variance_error(expected, n))
    offsets = [dn(camera(Fpn(sigma_e=spread * 0.01)), shot=shot)[0] for shot in shots]
    assert np.allclose(offsets[0], offsets[1], atol=1e-3)


@pytest.mark.parametrize("where", BACKENDS)
def test_dark_currents_are_log_normal(where: str) -> None:
    """Where u is s/d, the logarithm of d + s l has the variance v = ln(1 + u^2) and the mean
    ln d - v / 2; that of a normal pattern of the same deviation has more, and some have none."""
    current, spread, n = 9000.0, 4500.0, SIDE * SIDE
    uneven = spread / current
    cam = camera(DarkShot(current_e_per_s=current, spread_e_per_s=spread, uneven=uneven))
    shot = dataclasses.replace(dark_shot(), exposure_s=0.01, frames=1)
    charge = (dn(cam, where, shot)[0] - 100.0) / GAIN / 0.01 + current
    v = math.log1p(uneven**2)
    log = np.log(charge)
    assert_agree(
        [log.mean(), log.var()],
        [math.log(current) - v / 2, v],
        [math.sqrt(v / n), variance_error(v, n)],
    )
    other = current + spread * np.random.default_rng(1).standard_normal(n)
    assert np.any(other < 0)
    assert np.log(other[other > 0]).var() - v > 10 * variance_error(v, n)


def test_single_precision_is_enough() -> None:
    """Bias of the chain against double precision, at the largest signals of an 8-bit camera."""
    cam = camera(Fpn(sigma_e=50), Prnu(ratio=0.02), gain_dn_per_e=Colours.of(1 / 66))
    got = dn(cam)[0]
    b = backend()
    parts = {}
    for effect in cam.effects:
        pattern = stream_of(cam, effect, LIT, 0, range(1), b).body.normal(SIDE, SIDE)
        parts[effect.name] = np.asarray(pattern.numpy(), np.float64).reshape(SIDE, SIDE)
    electrons = RATE * 0.01 * (1 + 0.02 * parts["prnu"]) + 50 * parts["fpn"]
    assert abs((got - (electrons / 66 + 100.0)).mean()) < 1e-3
    assert np.abs(got - (electrons / 66 + 100.0)).max() < 1e-3


def test_effects_out_of_physical_order_are_refused_and_both_are_named() -> None:
    with pytest.raises(CameraError, match=r"'read_noise' before effect 'prnu'"):
        camera(effects=(ReadNoise(), Prnu()))
    with pytest.raises(CameraError, match="twice"):
        camera(effects=(Prnu(), Prnu(ratio=0.03)))


def test_plus_puts_effects_in_their_place_and_without_takes_them_out() -> None:
    cam = camera(Quantization(), Prnu(), ReadNoise(), PhotonShot())
    assert [e.name for e in cam.effects] == ["prnu", "photon_shot", "read_noise", "quantization"]
    assert cam.without(Prnu).get(Prnu) is None
    assert cam.plus(Prnu(ratio=0.05)).get(Prnu) == Prnu(ratio=0.05)


@pytest.mark.parametrize("name", preset_names())
def test_presets_simulate_and_give_what_they_promise(name: str) -> None:
    cam = load(name).resized(32, 48)
    light = {"lamp": np.full((32, 48, 3), RATE, np.float32)}
    shot = dataclasses.replace(LIT, frames=2)
    out = pixels_of(cam, simulate(cam, shot, light))
    assert out.shape[:3] == (2, 32, 48)
    assert out.max() <= cam.format.top_dn
    assert out.std() > 0


def test_an_rgb_camera_without_demosaicer_is_refused() -> None:
    cam = camera(Quantization(), pixels="rgb8", bits=8)
    with pytest.raises(CameraError, match="demosaic"):
        pixels_of(cam, simulate(cam, LIT, rates()))


def test_a_lamp_without_rate_image_and_one_of_another_size_are_refused() -> None:
    with pytest.raises(CameraError, match="no rate image"):
        simulate(camera(), LIT, {})
    with pytest.raises(CameraError, match="5 x 4 pixels"):
        simulate(camera(), LIT, {"lamp": np.ones((4, 5, 3), np.float32)})


def test_the_base_camera_is_in_the_catalogue() -> None:
    base = {name for name, kind in catalogue().items() if kind.base}
    assert base == {
        "prnu", "dark_shot", "photon_shot", "fpn", "read_noise", "demosaic", "quantization",
    }  # fmt: skip


def test_another_figure_of_the_camera_compiles_nothing() -> None:
    """Whatever calibration turns is data of the kernels: a fit has hundreds of cameras."""
    if not backend().jit:
        pytest.skip("no kernels without a JIT backend")

    def kernels(part: float) -> int:
        """Kernels compiled, or read from a disk, for a camera with so much of everything."""
        taken = camera(
            DarkShot(current_e_per_s=1e4 * part, shown_e_per_s=1e3 * part),
            PhotonShot(),
            Prnu(ratio=0.02 * part),
            Fpn(sigma_e=40.0 * part),
            ReadNoise(reset_e=30.0 * part, thermal_e=0.0, other_e=0.0),
            BlackLevelOffset(offset_e=50.0 * part),
            black_dn=4.0 * part,
            gain_dn_per_e=Colours.of(0.01 * part),
        )
        dr.kernel_history_clear()
        dn(taken)
        launched = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
        assert launched
        return sum(not kernel["cache_hit"] for kernel in launched)

    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        kernels(1.0)
        assert [kernels(part) for part in (1.3, 0.7)] == [0, 0]


@pytest.mark.parametrize("number", [np.float64(4000.0), np.float32(4000.0), np.int64(4000)])
def test_a_number_of_numpy_is_a_number(number: Any) -> None:
    held = Blooming(full_well_e=number)
    assert type(held.full_well_e) in (int, float)
    assert held == Blooming(full_well_e=4000.0)
