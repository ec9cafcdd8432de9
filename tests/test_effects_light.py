"""Lighting and optics: each effect obeys its closed form, and an impostor of equal strength fails.

Each test states the law as figures with expected values and standard errors, and puts to it the
frames of the effect and those of an impostor: independent noise or pixel gains of equal variance,
a random gain, a Gaussian blur of equal spread.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from scipy import ndimage, optimize

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.defocus_error import DefocusError
from sensor.effects.dust_shadow import DustShadow
from sensor.effects.lamp_displacement import LampDisplacement
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.lamp_flicker import LampFlicker
from sensor.effects.lamp_spectrum_error import LampSpectrumError
from sensor.effects.lateral_chromatic_aberration import LateralChromaticAberration
from sensor.effects.lens_distortion import LensDistortion
from sensor.effects.prnu import Prnu
from sensor.effects.read_noise import ReadNoise
from sensor.effects.specular_glare import SpecularGlare
from sensor.effects.veiling_glare import VeilingGlare
from sensor.effects.vibration import Vibration
from sensor.effects.vignetting_excess import VignettingExcess
from sensor.protocol import Shot
from sensor.signal import Quantity, Signal
from sensor.simulation import simulate
from sensor.stream import Stream
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
from tests.harness import variance_error, worst_z

Law = tuple[object, object, object]
HEIGHT, WIDTH = 64, 96
Y, X = np.mgrid[:HEIGHT, :WIDTH] - np.array([HEIGHT - 1, WIDTH - 1])[:, None, None] / 2
CORNER_PX = math.hypot(HEIGHT, WIDTH) / 2


def obeys(law: Law) -> bool:
    worst, limit = worst_z(*law)
    return worst <= limit


def noise_of(variance_e2: float) -> ReadNoise:
    """Independent noise: that of the bench and so much variance more."""
    return ReadNoise(reset_e=0.0, thermal_e=math.hypot(READ_E, math.sqrt(variance_e2)), other_e=0.0)


def frame_means(frames: Array) -> tuple[Array, float]:
    """Mean of each frame, and its standard error from the noise of the pixels."""
    noise = np.diff(frames - frames.mean((1, 2), keepdims=True), axis=0).var() / 2
    return frames.mean((1, 2)), math.sqrt(noise / frames[0].size)


@dataclass(frozen=True, kw_only=True)
class RandomGain(Effect):
    """The impostor of everything that changes in time: each frame has its own, independent gain."""

    name: ClassVar[str] = "random_gain"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 11
    reference: ClassVar[str] = "none: an impostor"
    sigma: float = parameter(0.0, unit="1", minimum=0.0, maximum=1.0, doc="standard deviation")

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value * (1.0 + self.sigma * stream.normal(1, 1, 1)))


@dataclass(frozen=True, kw_only=True)
class GainAfterShotNoise(Effect):
    """The impostor of another lamp: amplifiers of another gain by colour."""

    name: ClassVar[str] = "gain_after_shot_noise"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 1
    reference: ClassVar[str] = "none: an impostor"
    gain: float | Colours = parameter(
        1.0, unit="1", minimum=0.0, maximum=9.0, per_colour=True, doc="gain"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value * signal.by_colour(self.gain))


@dataclass(frozen=True, kw_only=True)
class Offset(Effect):
    """The impostor of light in the dark: a black level."""

    name: ClassVar[str] = "offset"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 1
    reference: ClassVar[str] = "none: an impostor"
    level_e: float = parameter(0.0, unit="e-", minimum=0.0, maximum=1e4, doc="offset")

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value + self.level_e)


# --- lighting -------------------------------------------------------------------------------------


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


def test_highlight_adds_one_lobe_of_light_whatever_lies_below() -> None:
    scene = np.where(X < 0, 500.0, 4000.0)
    sigma, strength = 6.0, 0.4
    gloss = SpecularGlare(strength=strength, across=0.5, below=0.5, sigma_px=sigma)
    total = 2 * math.pi * sigma**2 * strength * scene.mean()

    def law(*effects: Effect) -> Law:
        mean, error = mean_and_error(frames_of(*effects, rate=rate_of(scene), frames=32))
        weights = np.stack([X < 0, X > 0, X**2, Y**2]).astype(float)
        values = (weights * (mean - scene)).sum((1, 2))
        errors = np.sqrt((np.square(weights) * np.square(error)).sum((1, 2)))
        return values, total * np.array([0.5, 0.5, sigma**2, sigma**2]), errors

    assert obeys(law(gloss))
    assert not obeys(law(Offset(level_e=total / scene.size)))
    lobe = strength * scene.mean() * np.exp(-(X**2 + Y**2) / (2 * sigma**2))
    assert not obeys(law(noise_of(float(lobe.var()))))


# --- optics ---------------------------------------------------------------------------------------


def test_veil_fills_a_black_panel_with_its_part_of_the_scenes_mean() -> None:
    """In the middle of a black panel, where no blur of equal loss of contrast reaches."""
    v = 0.05
    inside = (np.abs(X) < 16) & (np.abs(Y) < 16)
    centre = (np.abs(X) < 4) & (np.abs(Y) < 4)
    scenes = [np.where(inside, 200.0, white) for white in (3000.0, 9000.0)]

    def blurred(scene: Array) -> Array:
        def contrast(s: float) -> float:
            return float(ndimage.gaussian_filter(scene, s).std() - (1 - v) * scene.std())

        return np.asarray(ndimage.gaussian_filter(scene, optimize.brentq(contrast, 0.1, 8.0)))

    def law(rates: list[Array], *effects: Effect) -> Law:
        stacks = [frames_of(*effects, rate=rate_of(rate), frames=32) for rate in rates]
        panels = [stack[:, centre] for stack in stacks]
        values = [p.mean() for p in panels] + [stack.mean() for stack in stacks]
        errors = [math.sqrt((200 + READ_E**2 + v * 9000) / p.size) for p in panels]
        errors += [math.sqrt(s.mean() / s.size) for s in stacks]
        expected = [(1 - v) * 200 + v * s.mean() for s in scenes] + [s.mean() for s in scenes]
        return values, expected, errors

    assert obeys(law(scenes, VeilingGlare(fraction=v)))
    assert not obeys(law([blurred(s) for s in scenes]))


def test_vignetting_is_even_on_rings_and_falls_along_the_polynomial() -> None:
    r2 = (X**2 + Y**2) / CORNER_PX**2
    fall = 1 - 0.05 * r2 - 0.05 * r2**2
    ring = np.minimum((r2 * 8).astype(int), 7)
    sector = (X > 0).astype(int) + 2 * (Y > 0)

    def law(*effects: Effect) -> Law:
        mean, error = mean_and_error(frames_of(*effects, rate=flat(8000)))
        area = (ring * 4 + sector).ravel()
        count = np.bincount(area)
        values, expected = (
            np.bincount(area, image.ravel()) / count for image in (mean, 8000 * fall)
        )
        errors = np.sqrt(np.bincount(area, np.square(error).ravel())) / count
        return values, expected, errors

    assert obeys(law(VignettingExcess(k2=0.05, k4=0.05)))
    assert not obeys(law(Prnu(ratio=float(fall.std()))))


def test_defocus_spreads_an_edge_over_its_disc_and_not_beyond() -> None:
    diameter = 8.0
    edge = np.where(X < 0, 500.0, 8000.0)

    def law(scene: Array, *effects: Effect) -> Law:
        frames = frames_of(*effects, rate=rate_of(scene), frames=32)
        columns, n = frames.mean((0, 1)), 32 * HEIGHT
        errors = np.sqrt((edge[0] + READ_E**2 + 1 / 12) / n)
        x = X[0]
        near, beyond = np.abs(x) < 12, (np.abs(x) > diameter / 2) & (np.abs(x) < 12)
        # the first moment of what an edge lost is half the variance of the spread
        moment = (x * (edge[0] - columns))[near].sum()
        half = 7500 * diameter**2 / 16 / 2
        moment_error = math.sqrt((np.square(x * errors)[near]).sum())
        return (
            [*columns[beyond], moment], [*edge[0][beyond], half], [*errors[beyond], moment_error]
        )  # fmt: skip

    assert obeys(law(edge, DefocusError(diameter_px=diameter)))
    assert not obeys(law(ndimage.gaussian_filter(edge, diameter / 4, mode="nearest")))


def test_defocus_blurs_the_light_and_not_its_noise() -> None:
    def law(frames: Array) -> Law:
        noise = frames - frames.mean(0)
        lag = (noise[:, :, 1:] * noise[:, :, :-1]).mean() / noise.var()
        return lag, 0.0, 1 / math.sqrt(noise[:, :, 1:].size)

    assert obeys(law(frames_of(DefocusError(diameter_px=3.0), rate=flat(8000))))
    assert not obeys(law(ndimage.gaussian_filter(frames_of(rate=flat(8000)), (0, 0.75, 0.75))))


def test_colour_fringes_scale_red_and_blue_about_the_centre() -> None:
    """On a ramp the slope of a colour falls as its magnification grows; a blur leaves it."""
    ramp = 2500.0 + 40.0 * X

    def law(scene: Array, *effects: Effect) -> Law:
        frames = frames_of(*effects, rate=rate_of(scene), frames=32, cfa="RGGB")
        mean, error = mean_and_error(frames)
        values, errors = [], []
        for y, x in ((0, 0), (0, 1), (1, 1)):
            place = X[y::2, x::2]
            use = np.abs(place) < 44
            place = place[use] - place[use].mean()
            share = place / np.square(place).sum()
            values.append((share * mean[y::2, x::2][use]).sum())
            errors.append(math.sqrt((np.square(share * error[y::2, x::2][use])).sum()))
        expected = [40 / (1 + 0.5 / CORNER_PX), 40, 40 / (1 - 0.5 / CORNER_PX)]
        return values, expected, errors

    blur = ndimage.gaussian_filter(ramp, 0.5, mode="nearest")
    assert obeys(law(ramp, LateralChromaticAberration(red_px=0.5, blue_px=-0.5)))
    assert not obeys(law(np.stack([blur, ramp, blur], -1)))


def test_distortion_bends_lines_and_keeps_the_scale_of_the_centre() -> None:
    ramp = 2500.0 + 40.0 * X
    r2 = (X**2 + Y**2) / CORNER_PX**2
    use = (np.abs(X) < 40) & (np.abs(Y) < 28)
    basis = np.stack([np.ones(use.sum()), X[use], Y[use], 40.0 * (X * r2)[use]], -1)

    def law(scene: Array, *effects: Effect) -> Law:
        mean, error = mean_and_error(frames_of(*effects, rate=rate_of(scene), frames=32))
        solve = np.linalg.pinv(basis)
        errors = np.sqrt(np.square(solve * error[use]).sum(1))
        return solve @ mean[use], [2500.0, 40.0, 0.0, 0.03], errors

    assert obeys(law(ramp, LensDistortion(k1=0.03)))
    assert not obeys(law(ndimage.gaussian_filter(ramp, 1.0, mode="nearest")))


def test_dust_shadows_are_cones_cut_off_of_any_size() -> None:
    depth, level = 0.3, 8000.0

    def law(body: int, *effects: Effect) -> tuple[float, float]:
        frames = frames_of(*effects, rate=flat(level), frames=64, body_seed=body)
        a, b = level - frames[::2].mean(0), level - frames[1::2].mean(0)
        variance = level / 32
        squares, total = (a * b).sum(), (a + b).sum() / 2
        value = squares / (depth * level * total)
        # propagated to first order, with the covariance of the two sums
        parts = (
            (np.square(a) + np.square(b)).sum() * variance / squares**2
            + a.size * variance / 2 / total**2
            - 2 * (a + b).sum() * variance / 2 / (squares * total)
        )
        return value, abs(value) * math.sqrt(parts)

    spots, gains = [], []
    for body in range(40):
        one = DustShadow(number=1.0, diameter_px=12.0, depth=depth)
        image = 1 - frames_of(one, rate=flat(level), body_seed=body).mean(0) / level
        y, x = ((image * place).sum() / image.sum() for place in (Y, X))
        whole = abs(y) < HEIGHT / 2 - 14 and abs(x) < WIDTH / 2 - 14
        if whole and len(spots) < 6:
            spots.append(law(body, one))
            gains.append(law(body, Prnu(ratio=float(image.std()))))
    assert len(spots) == 6
    for figures, passes in ((spots, True), (gains, False)):
        values, errors = np.array(figures).T
        assert obeys((values, 9 / 13, errors)) is passes


def test_vibration_moves_a_whole_slope_in_step() -> None:
    """Variance of the frame's mean on a ramp: slope^2 shift^2. Independent noise averages out."""
    slope, shift, frames = 30.0, 0.15, 200
    ramp = 2500.0 + slope * X

    def law(*effects: Effect) -> Law:
        stack = frames_of(*effects, rate=rate_of(ramp), frames=frames)[:, 4:-4, 4:-4]
        means = stack.mean((1, 2))
        expected = slope**2 * shift**2 + 2525 / stack[0].size
        return means.var(ddof=1), expected, variance_error(expected, frames)

    assert obeys(law(Vibration(shift_px=shift, blur_px=0.0)))
    assert not obeys(law(noise_of(slope**2 * shift**2)))


def test_vibration_within_the_exposure_widens_an_edge_by_its_variance() -> None:
    edge = np.where(X < 0, 500.0, 8000.0)

    def law(blur_px: float) -> Law:
        effect = Vibration(shift_px=0.0, blur_px=blur_px)
        columns = frames_of(effect, rate=rate_of(edge), frames=32).mean((0, 1))
        near = np.abs(X[0]) < 4
        moment = (X[0] * (edge[0] - columns))[near].sum()
        variances = (edge[0] + 3500) / (32 * HEIGHT)
        error = math.sqrt((np.square(X[0]) * variances)[near].sum())
        return moment, 7500 * 0.5**2 / 2, error

    assert obeys(law(0.5))
    assert not obeys(law(0.0))


@pytest.mark.parametrize(
    "kind",
    [
        DefocusError,
        DustShadow,
        LampDisplacement,
        LampSpectrumError,
        LateralChromaticAberration,
        LensDistortion,
        SpecularGlare,
        VeilingGlare,
        Vibration,
        VignettingExcess,
    ],
)
def test_light_is_linear_whether_it_differs_from_frame_to_frame_or_not(kind: type[Effect]) -> None:
    """Behind a lamp whose gain differs by frame, every frame is that gain times the steady one."""
    scene = rate_of(np.stack([2500 + 20 * X, 3000 + 500 * np.sin(X / 3), 3000 + 30 * Y], -1))
    shot = Shot(label="a", light=("lamp",), exposure_s=EXPOSURE_S, frames=4, interval_s=0.1)

    def rate(*effects: Effect) -> Array:
        camera = bench_camera(*effects, height=HEIGHT, width=WIDTH)
        signal = simulate(camera, shot, {"lamp": scene}, until=Quantity.RATE)
        return signal.numpy().astype(float)

    gain = rate(RandomGain(sigma=0.1))[:, :1, :1, :1] / rate()[:, :1, :1, :1]
    both, steady = rate(RandomGain(sigma=0.1), kind()), rate(kind())
    assert not np.allclose(steady, rate(), rtol=1e-4)
    # float32: some ten roundings of 6e-8
    assert np.allclose(both, gain * steady, rtol=2e-6)
