"""Optics: each effect obeys its closed form, and an impostor of equal strength fails.

Each test states the law as figures with expected values and standard errors, and puts to it the
frames of the effect and those of an impostor: independent noise or pixel gains of equal variance,
a random gain, a Gaussian blur of equal spread.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import ndimage, optimize, stats

from sensor.effect import Effect
from sensor.effects.defocus_error import DefocusError
from sensor.effects.dust_shadow import DustShadow
from sensor.effects.lamp_displacement import LampDisplacement
from sensor.effects.lamp_spectrum_error import LampSpectrumError
from sensor.effects.lateral_chromatic_aberration import LateralChromaticAberration
from sensor.effects.lens_distortion import LensDistortion
from sensor.effects.prnu import Prnu
from sensor.effects.specular_glare import SpecularGlare
from sensor.effects.veiling_glare import VeilingGlare
from sensor.effects.vibration import Vibration
from sensor.effects.vignetting_excess import VignettingExcess
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
    CORNER_PX,
    HEIGHT,
    WIDTH,
    Law,
    RandomGain,
    X,
    Y,
    noise_of,
    obeys,
)


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


def test_a_veil_of_short_reach_is_the_light_about_each_pixel() -> None:
    """A bright half beside a dark one: with normal weights of standard deviation s the veil at x px
    from the border is that of the two times Phi(x / s), and an even veil is the same everywhere."""
    v, reach = 0.1, 0.2
    side = flat(200.0)
    side[:, WIDTH // 2 :] *= 20

    def veil(effect: VeilingGlare) -> np.ndarray:
        shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=EXPOSURE_S, frames=2)
        camera = bench_camera(effect, height=side.shape[0], width=side.shape[1])
        made = simulate(camera, shot, {"lamp": side}, until=Quantity.RATE).numpy()[0, :, :, 1]
        return np.asarray((made - (1 - v) * side[..., 1]).mean(axis=0) / v)

    x = np.arange(WIDTH) - (WIDTH - 1) / 2
    low, high = float(side[0, 0, 1]), float(side[0, -1, 1])
    expected = low + (high - low) * stats.norm.cdf(x / (reach * side.shape[0]))
    middle = np.abs(x) < WIDTH / 4
    found = veil(VeilingGlare(fraction=v, reach=reach))
    assert np.allclose(found[middle], expected[middle], atol=0.02 * (high - low))
    assert np.ptp(veil(VeilingGlare(fraction=v))) < 1e-3 * (high - low)


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
