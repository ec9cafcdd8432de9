"""Full photosites are told by where pictures end, and their camera by what is well below."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.blooming import brimful
from analysis.gap.ready.full_well import Dark, Samples, full_well_e, levels_of_full
from analysis.gap.ready.setting import Setting, look
from sensor.colours import Colours
from sensor.effects.blooming import Blooming
from sensor.effects.nonlinearity import Nonlinearity
from sensor.frames import Capture, Frames
from sensor.protocol import Shot
from sensor.record import record
from tests.short import PROTOCOL, camera, light

FULL_E = 4000.0
"""The brightest patches have 3,000 in the dim shot and 7,600 in the bright one."""

FULL_IN_EVERY_SHOT_E = 2200.0


def taken(*effects: Blooming) -> Capture:
    """A dark, a dim and a bright shot."""
    made = camera().plus(*effects).with_body(5)
    return record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=5)


STEEP_DN_PER_E = 0.055
"""A gain by which the converter ends at 4,500 e-."""

ABOVE_ITS_END_E = 4600.0


def taken_by_a_short_converter(drained: float) -> Capture:
    """A bright shot with up to 5,000 e-, of which a twelfth is clipped, full or not."""
    dark, dim, bright = PROTOCOL.shot
    shots = (dark, dim, dataclasses.replace(bright, level=(0.65,)))
    made = dataclasses.replace(camera(), gain_dn_per_e=Colours.of(STEEP_DN_PER_E))
    made = made.plus(Blooming(full_well_e=ABOVE_ITS_END_E, drained=drained)).with_body(5)
    protocol = dataclasses.replace(PROTOCOL, shot=shots)
    return record(made, protocol, {"lamp": light().rate_e_per_s}, seed=5)


def setting_of(capture: Capture) -> Setting:
    setting = look(capture, {"lamp": light()})
    assert setting is not None
    return setting


@pytest.mark.parametrize("full_e", [FULL_E, FULL_IN_EVERY_SHOT_E])
def test_the_camera_of_full_photosites_is_told_by_what_is_well_below(full_e: float) -> None:
    """Samples that are not full tell the gain to sqrt(2 / n) of n of them and frames, and to what
    medians of variances in whole codes are off, 3 %. The brightest hundredth of those that are
    tell the product with the full well: they lie some 2.7 standard deviations above it, of 0.25 DN
    of offsets and noise in the mean of 16 frames. The darkest blocks tell the light, which is 1
    here, to as much as its gain and to what runs over into all of them."""
    told = brimful(setting_of(taken(Blooming(full_well_e=full_e, drained=0.8))))
    assert told is not None
    assert told.base is not None
    found_e = told.hints["full_well_e"]
    assert isinstance(found_e, float)
    gain = np.array([*camera().gain_dn_per_e])
    above_dn = told.base.gain_dn_per_e * found_e - gain * full_e
    np.testing.assert_allclose(above_dn, 0.0, atol=2.7 * 0.25)
    assert found_e == pytest.approx(full_e, rel=3 * 0.03)
    bright = told.base.level["lamp"] * told.base.gain_dn_per_e / gain
    np.testing.assert_allclose(bright, 1.0, atol=0.03)
    assert told.instead is not None
    assert told.instead.hints["drained"] == 0.0


def test_nothing_is_told_of_photosites_that_are_not_full() -> None:
    assert brimful(setting_of(taken())) is None


def test_the_camera_is_told_as_well_where_the_converter_ends_first() -> None:
    """What lies at its end tells no product of gain and full well, but that it is at least there;
    the gain is told by samples below to 3 %, and the light by the darkest blocks."""
    told = brimful(setting_of(taken_by_a_short_converter(drained=0.5)))
    assert told is not None
    assert told.base is not None
    gain = told.base.gain_dn_per_e / STEEP_DN_PER_E
    np.testing.assert_allclose(gain, 1.0, atol=2 * 0.03)
    np.testing.assert_allclose(told.base.level["lamp"] * gain, 1.0, atol=0.03)
    at_least_e = (TOP_DN - 6.0) / STEEP_DN_PER_E
    assert told.hints["full_well_e"] == pytest.approx(at_least_e, rel=2 * 0.03)


@pytest.mark.whole
def test_blooming_is_named_under_the_light_that_was_stated() -> None:
    """A base that knows no full photosites makes the light as flat as they are, and under such a
    light nothing fills them: the search begins under the stated one."""
    capture = taken(Blooming(full_well_e=FULL_E, drained=0.8))
    found = diagnose(capture, stated={"lamp": light()}, suspects=[Blooming, Nonlinearity]).report
    assert [e.name for e in found.effects] == ["blooming"]
    blooming = found.effects[0].parameters
    assert blooming["full_well_e"].value == pytest.approx(FULL_E, rel=3 * 0.03)
    assert blooming["drained"].value == pytest.approx(0.8, abs=0.05)
    assert found.gap.after < 1e-3 * found.gap.before


@pytest.mark.whole
@pytest.mark.parametrize("drained", [0.0, 0.5])
def test_blooming_is_named_by_what_runs_over_where_the_converter_ends_first(
    drained: float,
) -> None:
    """All that is seen of full photosites is their surroundings."""
    capture = taken_by_a_short_converter(drained)
    found = diagnose(capture, stated={"lamp": light()}, suspects=[Blooming, Nonlinearity]).report
    assert found.verdict == "explained"
    assert [e.name for e in found.effects] == ["blooming"]
    for name, true in (("full_well_e", ABOVE_ITS_END_E), ("drained", drained)):
        fitted = found.effects[0].parameters[name]
        assert fitted.se is not None
        assert fitted.value == pytest.approx(true, abs=3 * fitted.se)


TOP_DN = 255
GAIN, BLACK_DN, READ_E = 0.04, 5.0, 12.0


def exposed(brightest_e: float, full_e: float = np.inf, read_e: float = READ_E) -> np.ndarray:
    """A ramp of light along the rows, (16, 96, 128), and what photosites hold of it, in 8 bits."""
    rng = np.random.default_rng(9)
    light = np.broadcast_to(np.linspace(0.02, 1.0, 128) * brightest_e, (16, 96, 128))
    held = np.minimum(rng.poisson(light), full_e)
    dn = np.round(GAIN * (held + rng.normal(0, read_e, held.shape)) + BLACK_DN)
    return np.clip(dn, 0, TOP_DN).astype(np.float32)


def test_full_photosites_are_those_that_are_quiet() -> None:
    """A full one has the noise of its read-out and of the rounding, no photons: here

    (0.04 x 12)^2 + 1/12 = 0.31 DN^2,  of light half as bright 0.04^2 x 2250 + 0.31 = 3.9 DN^2."""
    found = end_of(exposed(6000.0, full_e=4500.0))
    assert found == pytest.approx(GAIN * 4500.0 + BLACK_DN, abs=0.5)


def end_of(*shots: np.ndarray, read_e: float = READ_E) -> float | None:
    """The level at which the last of the shots of one colour stops."""
    dark = Dark(mean_dn=BLACK_DN, variance_dn2=(GAIN * read_e) ** 2 + 1 / 12)
    return levels_of_full([Samples.of(dn, TOP_DN) for dn in shots], dark)[-1]


def test_full_photosites_are_told_behind_any_read_noise() -> None:
    """Of (0.04 x 60)^2 = 5.8 DN^2 of a full one and 9.4 DN^2 of one half as bright, light makes
    none and 3.6: their ratio is 0.6 with the noise of the dark in both, and 0 without. The
    brightest hundredth lie above the level by 2.7 x 2.4 DN / sqrt(16) = 1.6 DN."""
    loud = exposed(6000.0, full_e=4500.0, read_e=60.0)
    assert end_of(loud, read_e=60.0) == pytest.approx(GAIN * 4500.0 + BLACK_DN, abs=2.0)
    assert end_of(exposed(4500.0, read_e=60.0), read_e=60.0) is None


def test_light_behind_a_curve_is_no_full_well() -> None:
    """A curve of slope g has g^2 times the noise: a root makes dark samples the loudest of all."""
    straight = exposed(4500.0)
    bent = np.sqrt(straight * TOP_DN)
    dark = Dark(mean_dn=float(np.sqrt(BLACK_DN * TOP_DN)), variance_dn2=4.0)
    assert levels_of_full([Samples.of(bent, TOP_DN)], dark) == [None]


def test_light_that_is_hardly_clipped_is_no_full_well() -> None:
    """Of 1.4 % of all samples, which would be 254.8 DN, half lie at the top: less than a hundredth
    of all, and the noise of those is half gone."""
    hardly = exposed(6000.0)
    rng = np.random.default_rng(3)
    brightest = np.round(rng.normal(254.8, 3.3, (16, 172)))
    hardly.reshape(16, -1)[:, :172] = np.minimum(brightest, TOP_DN)
    assert not Samples.of(hardly, TOP_DN).clipped
    assert end_of(hardly) is None


def test_a_shot_with_nothing_below_full_is_told_by_another_one() -> None:
    """Samples half as bright as full ones have the same noise in any shot."""
    bright = exposed(60_000.0, full_e=4500.0)[:, :, 64:]
    assert end_of(bright) is None
    assert end_of(exposed(4000.0), bright) == pytest.approx(GAIN * 4500.0 + BLACK_DN, abs=0.5)


def test_the_brightest_light_is_no_full_well() -> None:
    assert end_of(exposed(4500.0)) is None


def test_frames_that_the_converter_clips_say_how_much_is_held_at_least() -> None:
    """In electrons of the camera as it is calibrated; of frames that end below nothing is said."""
    site = Lattice(name="Y", channel="Y", dy=0, dx=0, step=1)
    shot = Shot(label="lit", light=("lamp",), exposure_s=0.02, frames=16)
    figures = np.array([GAIN]), np.array([BLACK_DN])
    base: Any = SimpleNamespace(channels=("Y",), gain_dn_per_e=figures[0], black_dn=figures[1])

    def found(brightest_e: float, full_e: float = np.inf) -> float | None:
        dn = exposed(brightest_e, full_e).astype(np.uint8)
        return full_well_e(
            [Frames(shot=shot, dn=dn, bits=8, pixels="mono8", cfa=None)], [site], base
        )

    assert found(4500.0) is None
    assert found(6000.0, 4500.0) == pytest.approx(4500.0, rel=0.02)
    assert found(9000.0) == pytest.approx((TOP_DN - BLACK_DN) / GAIN)
