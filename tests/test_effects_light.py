"""Lighting: each effect obeys its closed form, and an impostor of equal strength fails.

Each test states the law as figures with expected values and standard errors, and puts to it the
frames of the effect and those of an impostor: independent noise or pixel gains of equal variance,
a random gain, a Gaussian blur of equal spread.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from sensor.effect import Effect
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.lamp_displacement import LampDisplacement
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.lamp_flicker import LampFlicker
from sensor.effects.lamp_spectrum_error import LampSpectrumError
from sensor.effects.prnu import Prnu
from sensor.effects.specular_glare import SpecularGlare
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import simulate
from tests.effects_bench import (
    EXPOSURE_S,
    READ_E,
    Array,
    bench_camera,
    flat,
    frames_of,
    mean_and_error,
    rate_of,
)
from tests.harness import variance_error
from tests.light_bench import (
    WIDTH,
    GainAfterShotNoise,
    Law,
    Offset,
    RandomGain,
    X,
    Y,
    frame_means,
    noise_of,
    obeys,
)


def test_flicker_repeats_with_the_beat_of_mains_and_frame_rate() -> None:
    """100 half cycles a second, seen 15 times: 6 2/3 each, so that every third frame is equal."""

    def law(*effects: Effect) -> Law:
        means, error = frame_means(frames_of(*effects, rate=flat(8000), frames=24))
        return means[3:] - means[:-3], 0.0, math.sqrt(2) * error

    own = LampFlicker(mains_hz=50.0)
    means, error = frame_means(frames_of(own, rate=flat(8000), frames=24))
    # mean over the shutter of the series 1 - 2 sum cos(2 pi k u) / (4 k^2 - 1), n half cycles long
    n = 100 * EXPOSURE_S
    harmonics = [2 / (4 * k**2 - 1) * np.sinc(k * n) for k in range(1, 200)]
    rms = 8000 * own.depth * math.sqrt(np.square(harmonics).sum() / 2)
    assert means.std() > 0.3 * rms > 10 * error
    assert obeys(law(own))
    assert not obeys(law(RandomGain(sigma=means.std() / 8000)))


def test_flicker_is_the_shutters_mean_of_the_ripple_and_gone_after_whole_half_cycles() -> None:
    """Over random phases the gain's variance is that of the Fourier series, for any exposure."""

    def law(exposure_s: float, *effects: Effect) -> Law:
        # an interval that is no simple part of the mains visits all phases evenly
        frames = frames_of(
            *effects, rate=flat(8000) * np.float32(EXPOSURE_S / exposure_s), frames=89,
            exposure_s=exposure_s, interval_s=0.1 + 0.01 * 34 / 89,
        )  # fmt: skip
        means, error = frame_means(frames)
        n = 100 * exposure_s
        harmonics = [2 / (4 * k**2 - 1) * np.sinc(k * n) for k in range(1, 400)]
        expected = (8000 * 0.2) ** 2 * np.square(harmonics).sum() / 2
        # the phases are a lattice of 89, over which the series' cross terms vanish
        spread = math.sqrt(4 * expected * error**2 / 89 + 2 * error**4 / 89)
        return means.var(), expected + error**2, spread

    flicker = LampFlicker(depth=0.2, mains_hz=50.0)
    for exposure_s in (0.0042, 0.02, 0.03, EXPOSURE_S):
        assert obeys(law(exposure_s, flicker)), exposure_s
        assert not obeys(law(exposure_s, RandomGain(sigma=0.02))), exposure_s


def test_a_filament_flickers_by_its_own_share_of_the_depth() -> None:
    """The gain less 1 is that of any other lamp, times `filament`; other lamps keep theirs."""
    quiet, loud = (LampFlicker(depth=0.4, filament=part) for part in (0.25, 1.0))

    def gains(effect: LampFlicker, lamp: str) -> np.ndarray:
        shot = Shot(label="lit", light=(lamp,), level=(1.0,), exposure_s=0.0042, frames=12)
        made = simulate(
            bench_camera(effect, height=8, width=8), shot, {lamp: flat(8000)[:8, :8]},
            until=Quantity.RATE,
        )  # fmt: skip
        return made.numpy()[:, 0, 0, 0] / flat(8000)[0, 0, 0] - 1

    assert np.ptp(gains(loud, "incandescent")) > 0.1
    assert np.allclose(gains(quiet, "incandescent"), gains(loud, "incandescent") / 4, atol=1e-6)
    assert np.array_equal(gains(quiet, "fluorescent"), gains(loud, "fluorescent"))


def test_warm_up_slows_down_by_one_factor_in_equal_times() -> None:
    drift = LampDrift(change=0.05, time_constant_s=10.0)

    def law(*effects: Effect) -> Law:
        means, error = frame_means(frames_of(*effects, rate=flat(8000), frames=40, interval_s=0.5))
        q = math.exp(-10 * 0.5 / 10.0)
        steps = means[10:] - means[:-10]
        return steps[10:], q * steps[:-10], error * math.sqrt(1 + (1 + q) ** 2 + q**2)

    means, error = frame_means(frames_of(drift, rate=flat(8000), frames=40, interval_s=0.5))
    assert abs(means[-1] - 8000 * (1 + 0.05 * (1 - math.exp(-19.5 / 10)))) < 5 * error
    assert obeys(law(drift))
    assert not obeys(law(RandomGain(sigma=means.std() / 8000)))


def lamp_gains(drift: LampDrift, lamp: str, label: str) -> np.ndarray:
    """Light of a shot of 40 frames relative to nominal, (F,)."""
    shot = Shot(
        label=label, light=(lamp,), level=(1.0,), exposure_s=EXPOSURE_S, frames=40, interval_s=0.5
    )
    made = simulate(
        bench_camera(drift, height=8, width=8), shot, {lamp: flat(8000)[:8, :8]},
        until=Quantity.RATE,
    )  # fmt: skip
    return np.asarray(made.numpy()[:, 0, 0, 0] / flat(8000)[0, 0, 0])


def test_a_filament_drifts_by_its_own_change() -> None:
    """The gain less 1 is that of any other lamp, times `filament`."""
    drift = LampDrift(change=0.04, time_constant_s=5.0, filament=-0.5)
    gas, wire = (lamp_gains(drift, lamp, "lit") - 1 for lamp in ("fluorescent", "incandescent"))
    assert gas[-1] > 0.03
    assert np.allclose(wire, -0.5 * gas, atol=1e-6)


def test_a_lamp_that_was_on_before_has_a_share_of_its_change_to_come() -> None:
    """What is still missing dies out as ever, and begins with a share r of the change that is drawn
    evenly for each shot: over 200 shots a mean of 1/2, a variance of 1/12, at 4 standard errors."""
    change, tau_s = 0.04, 5.0
    drift = LampDrift(change=change, time_constant_s=tau_s, on_before=1.0)
    missing = np.array(
        [1 - (lamp_gains(drift, "lamp", f"lit {k}") - 1) / change for k in range(200)]
    )
    falls = missing[:, 1:] / missing[:, :-1]
    clear = missing[:, 1:] > 0.05
    assert np.allclose(falls[clear], math.exp(-0.5 / tau_s), atol=1e-3)
    within = -math.expm1(-EXPOSURE_S / tau_s) * tau_s / EXPOSURE_S
    share = missing[:, 0] / within
    assert ((share >= -1e-3) & (share <= 1 + 1e-3)).all()
    assert abs(share.mean() - 0.5) < 4 * math.sqrt(1 / 12 / 200)
    assert abs(share.var() - 1 / 12) < 4 * math.sqrt((1 / 80 - 1 / 144) / 200)


def test_ambient_light_brings_its_own_shot_noise_and_grows_with_the_exposure() -> None:
    added = 2000 * EXPOSURE_S

    def law(*effects: Effect) -> Law:
        short, long = (
            frames_of(*effects, rate=flat(1000), level=0.0, exposure_s=t)
            for t in (EXPOSURE_S, 3 * EXPOSURE_S)
        )
        values = [short.mean(), long.mean(), short.var(), long.var()]
        dark = READ_E**2 + 1 / 12
        variances = np.array([added + dark, 3 * added + dark])
        n = short.size
        errors = [*np.sqrt(variances / n), *variance_error(variances, n)]
        return values, [added, 3 * added, *variances], errors

    assert obeys(law(AmbientLight(rate_e_per_s=2000.0)))
    assert not obeys(law(noise_of(added)))
    assert not obeys(law(Offset(level_e=added)))


def test_ambient_light_ignores_the_lamps_level_and_stays_out_under_the_cap() -> None:
    for share in (0.0, 1.0):
        room = AmbientLight(rate_e_per_s=2000.0, share_in_dark=share)
        for level in (0.0, 0.5, 1.0):
            frames = frames_of(room, rate=flat(1000), level=level)
            extra = 2000 * EXPOSURE_S * (share if level == 0 else 1.0)
            error = math.sqrt(frames.var() / frames.size)
            assert obeys((frames.mean(), 1000 * level + extra, error))


def test_ambient_light_by_way_of_the_scene_is_its_picture_even_in_the_dark() -> None:
    """In a dark shot each half of the picture has its own share of the light, 1.5 and 0.5 of the
    mean; light that falls evenly has not."""
    half = flat(500)
    half[:, : WIDTH // 2] *= 3

    def law(part: float) -> Law:
        room = AmbientLight(rate_e_per_s=2000.0, by_the_scene=part)
        frames = frames_of(room, rate=half, level=0.0)
        left, right = frames[..., : WIDTH // 2], frames[..., WIDTH // 2 :]
        added = 2000 * EXPOSURE_S
        error = np.sqrt([left.var() / left.size, right.var() / right.size])
        return [left.mean(), right.mean()], [1.5 * added, 0.5 * added], error

    assert obeys(law(1.0))
    assert not obeys(law(0.0))


def test_a_window_makes_what_comes_by_way_of_the_scene_brighter_on_its_side() -> None:
    """Over an even scene halves of the picture have 1 + slope / 2 and 1 - slope / 2 of the mean;
    light that does not come by the scene has no slope."""

    def law(part: float) -> Law:
        room = AmbientLight(
            rate_e_per_s=2000.0, by_the_scene=part, to_the_right=0.4, to_the_top=-0.2
        )
        frames = frames_of(room, rate=flat(500), level=0.0)
        middle, half = frames.shape[1] // 2, frames.shape[2] // 2
        parts = [
            frames[..., :half], frames[..., half:], frames[:, :middle], frames[:, middle:],
        ]  # fmt: skip
        added = 2000 * EXPOSURE_S
        expected = added * np.array([0.8, 1.2, 0.9, 1.1])
        return [one.mean() for one in parts], expected, [one.std() / one.size**0.5 for one in parts]

    assert obeys(law(1.0))
    assert not obeys(law(0.0))


def test_displaced_lamp_lights_by_cosine_over_distance_squared() -> None:
    moved = LampDisplacement(right_cm=3.0, up_cm=-2.0, away_cm=4.0)
    cm = 28.0 / WIDTH

    def light(right: float, up: float, away: float) -> Array:
        distance = np.sqrt((right - cm * X) ** 2 + (up + cm * Y) ** 2 + away**2)
        return (away / distance) / distance**2

    ratio = light(3.0, 38.0, 49.0) / light(0.0, 40.0, 45.0)

    def law(*effects: Effect) -> Law:
        mean, error = mean_and_error(frames_of(*effects, rate=flat(8000)))
        bands = mean.reshape(8, 8, 12, 8).mean((1, 3))
        errors = np.sqrt(np.square(error).reshape(8, 8, 12, 8).mean((1, 3)) / 64)
        return bands, 8000 * ratio.reshape(8, 8, 12, 8).mean((1, 3)), errors

    assert obeys(law(moved))
    assert not obeys(law(Prnu(ratio=float(ratio.std()))))


def test_another_colour_temperature_tilts_red_against_blue_and_stays_light() -> None:
    lamp = LampSpectrumError(shift_k=150.0)

    def law(*effects: Effect) -> Law:
        frames = frames_of(*effects, rate=flat(8000), frames=64, cfa="RGGB")
        red, green, blue = frames[:, ::2, ::2], frames[:, ::2, 1::2], frames[:, 1::2, 1::2]
        n = red.size
        logs = [math.log(colour.mean() / 8000) for colour in (red, green, blue)]
        # Wien's law, exact here to 1e-3 of the tilt: log gains as differences of 1 / wavelength
        tilt = (1 / 610 - 1 / 530) / (1 / 460 - 1 / 530)
        fano = [
            (colour.var(0, ddof=1).mean() - READ_E**2 - 1 / 12) / colour.mean()
            for colour in (red, green, blue)
        ]
        each = math.sqrt(1 / (8000 * n))
        values = [logs[1], logs[0] - tilt * logs[2], *fano]
        errors = [each, each * math.hypot(1, tilt), *[math.sqrt(2 / (n * 63 / 64))] * 3]
        return values, [0, 0, 1, 1, 1], errors

    assert lamp.gains.R < 0.97
    assert lamp.gains.B > 1.03
    assert obeys(law(lamp))
    assert not obeys(law(GainAfterShotNoise(gain=lamp.gains)))


@pytest.mark.parametrize("longer", [1.0, 2.25])
def test_highlight_adds_one_lobe_of_light_whatever_lies_below(longer: float) -> None:
    """Upright where it is longer than wide: its second moments are sigma^2 l down and sigma^2 / l
    across."""
    scene = np.where(X < 0, 500.0, 4000.0)
    sigma, strength = 6.0, 0.4
    gloss = SpecularGlare(
        strength=strength, across=0.5, below=0.5, sigma_px=sigma, longer=longer, slant_deg=90.0
    )
    total = 2 * math.pi * sigma**2 * strength * scene.mean()

    def law(*effects: Effect) -> Law:
        mean, error = mean_and_error(frames_of(*effects, rate=rate_of(scene), frames=32))
        weights = np.stack([X < 0, X > 0, X**2, Y**2]).astype(float)
        values = (weights * (mean - scene)).sum((1, 2))
        errors = np.sqrt((np.square(weights) * np.square(error)).sum((1, 2)))
        expected = np.array([0.5, 0.5, sigma**2 / longer, sigma**2 * longer])
        return values, total * expected, errors

    assert obeys(law(gloss))
    assert obeys(law(dataclasses.replace(gloss, slant_deg=30.0))) is (longer == 1.0)
    assert not obeys(law(Offset(level_e=total / scene.size)))
    lobe = strength * scene.mean() * np.exp(-(X**2 + Y**2) / (2 * sigma**2))
    assert not obeys(law(noise_of(float(lobe.var()))))
