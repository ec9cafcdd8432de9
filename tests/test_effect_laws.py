"""Laws that every effect of the catalogue obeys, by being in the folder."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from foundation.backend import backend
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect, Stage
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.photon_shot import PhotonShot
from sensor.effects.prnu import Prnu
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.errors import CameraError
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate, stream_of
from tests.backends import BACKENDS
from tests.harness import z_limit

KINDS = list(catalogue().values())
HEIGHT, WIDTH = 48, 64
SHOT = Shot(
    label="lit",
    light=("lamp",),
    exposure_s=0.0327,
    frames=8,
    interval_s=0.0667,
    temperature_c=29.0,
)

NAMES = set(
    """
lamp_flicker lamp_drift ambient_light lamp_displacement lamp_spectrum_error specular_glare
veiling_glare vignetting_excess defocus_error lateral_chromatic_aberration lens_distortion
dust_shadow vibration
spectral_response_error crosstalk dark_current hot_pixels random_telegraph_noise large_scale_prnu
brighter_fatter nonlinearity blooming image_lag
smear charge_transfer_inefficiency
row_noise column_fpn interference flicker_noise black_level_drift black_level_offset
adc_dnl bit_truncation
gamma white_balance color_matrix sharpening spatial_denoise temporal_filter demosaic_other
defect_correction
chroma_subsampling jpeg dropped_frames
prnu dark_shot photon_shot fpn read_noise demosaic quantization
""".split()  # noqa: SIM905  the table of names, as it is published
)


def scene() -> dict[str, np.ndarray]:
    """A ramp with a bright and a dark square, so that every kind of effect has something to do."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    rate = 1.0e5 + 1e3 * x + 5e2 * y
    rate[10:22, 12:26] *= 3.0
    rate[26:40, 36:52] *= 0.1
    return {"lamp": (rate[..., None] * np.array([1.1, 1.0, 0.8])).astype(np.float32)}


def camera(*effects: Effect, body_seed: int = 0) -> Camera:
    base = Camera(
        name="law",
        width=WIDTH,
        height=HEIGHT,
        gain_dn_per_e=Colours.of(1 / 66),
        black_dn=12.0,
        body_seed=body_seed,
        effects=(
            Prnu(), PhotonShot(), Fpn(sigma_e=30), ReadNoise(thermal_e=60), Demosaic(),
            Quantization(),
        ),
    )  # fmt: skip
    return base.plus(*effects)


def codes(cam: Camera, *, seed: int = 3, frames: range = range(6), where: str | None = None):
    signal = simulate(cam, SHOT, scene(), seed=seed, frames=frames, where=backend(where))
    return pixels_of(cam, signal)


def before_and_after(kind: type[Effect]) -> tuple[np.ndarray, np.ndarray]:
    cam = camera(kind())
    less = dataclasses.replace(cam, effects=tuple(e for e in cam.effects if e.name != kind.name))
    if kind.name in ("demosaic", "quantization"):
        unrounded = simulate(less, SHOT, scene(), seed=3, frames=range(6), until=Quantity.DN)
        return unrounded.numpy(), codes(cam)
    return codes(less), codes(cam)


def test_the_catalogue_has_every_name_and_no_other() -> None:
    assert set(catalogue()) == NAMES


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_it_says_what_it_is(kind: type[Effect]) -> None:
    assert isinstance(kind.stage, Stage)
    assert len(kind.reference) > 10
    assert len((kind.__doc__ or "").split()) >= 15
    assert not kind.__subclasses__()
    for p in kind.parameters():
        assert p.unit
        assert p.doc
        assert p.minimum <= p.default <= p.maximum
        assert math.isfinite(p.minimum)
        assert math.isfinite(p.maximum)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_at_its_defaults_it_does_something(kind: type[Effect]) -> None:
    """Some code somewhere must change: an effect that forgets to return its work fails here."""
    before, after = before_and_after(kind)
    assert before.shape != after.shape or not np.array_equal(before, after)


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_it_returns_new_numbers_and_leaves_its_input_alone(kind: type[Effect], where: str) -> None:
    cam = camera()
    before = tuple(e for e in cam.effects if e.place() < kind.place())
    until = kind.quantity()
    upstream = dataclasses.replace(cam, effects=before)
    signal = simulate(upstream, SHOT, scene(), until=until, frames=range(2), where=backend(where))
    original = signal.numpy().copy()
    effect = kind()
    stream = stream_of(cam, effect, SHOT, 1, signal.frames, signal.backend)
    out = effect.apply(signal, stream)
    out.numpy()
    assert np.array_equal(signal.numpy(), original)
    assert out is not signal


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_a_frame_is_the_same_again_and_alone_and_in_any_batch(
    kind: type[Effect], where: str
) -> None:
    cam = camera(kind())
    whole = codes(cam, where=where, frames=range(5))
    assert np.array_equal(codes(cam, where=where, frames=range(5)), whole)
    assert np.array_equal(codes(cam, where=where, frames=range(3, 4))[0], whole[3])
    assert np.array_equal(codes(cam, where=where, frames=range(2, 5)), whole[2:])


@pytest.mark.parametrize("where", BACKENDS)
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_at_zero_strength_it_is_the_identity(kind: type[Effect], where: str) -> None:
    zero = {p.name: p.identity for p in kind.parameters() if p.identity is not None}
    if not zero:
        assert kind.base or kind.name in ("jpeg", "demosaic_other", "chroma_subsampling")
        return
    cam = camera(kind(**zero))
    less = dataclasses.replace(cam, effects=tuple(e for e in cam.effects if e.name != kind.name))
    assert np.array_equal(codes(cam, where=where), codes(less, where=where))


@pytest.mark.parametrize("kind", [k for k in KINDS if k.product], ids=lambda kind: kind.name)
def test_without_any_factor_of_its_strength_it_is_the_identity(kind: type[Effect]) -> None:
    cam = camera(kind())
    less = dataclasses.replace(cam, effects=tuple(e for e in cam.effects if e.name != kind.name))
    assert not np.array_equal(codes(cam), codes(less))
    for p in kind.parameters():
        if p.identity is not None:
            assert np.array_equal(codes(camera(kind(**{p.name: p.identity}))), codes(less)), p.name


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_parameters_outside_their_range_are_refused_with_the_range(kind: type[Effect]) -> None:
    for p in kind.parameters():
        for value in (p.maximum + max(1.0, abs(p.maximum)), p.minimum - 1.0, math.nan, math.inf):
            with pytest.raises(CameraError, match=r"expected .* to "):
                kind(**{p.name: value})


@pytest.mark.skipif(len(BACKENDS) < 2, reason="only one backend works here")
@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_backends_agree_in_distribution(kind: type[Effect]) -> None:
    """Welch's z between backends of mean, spread, and difference of neighbours, over 10 bodies."""

    def figures(where: str) -> np.ndarray:
        rows = []
        for body in range(10):
            frame = codes(
                camera(kind(), body_seed=body), seed=body, frames=range(1, 3), where=where
            ).astype(float)
            right, later = np.diff(frame, axis=2), frame[1] - frame[0]
            rows.append([frame.mean(), np.log(frame.std()), np.log(right.std()), later.std()])
        return np.array(rows)

    a, b = figures("llvm"), figures("scalar")
    error = np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / len(a)) + 1e-6
    # ten bodies: Student's t has wider tails than the normal law; 2 covers 18 degrees of freedom
    assert (np.abs(a.mean(0) - b.mean(0)) / error).max() < 2 * z_limit(4 * len(KINDS))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_parameters_survive_a_camera_file(kind: type[Effect]) -> None:
    effect = kind()
    assert kind.with_parameters(effect.values()) == effect
