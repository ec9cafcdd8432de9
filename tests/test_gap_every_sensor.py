"""What every sensor has is calibrated and not taken for a gap; of other programs' cameras, too."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from analysis.gap.calibrate.fit import around
from analysis.gap.camera import light_ways
from analysis.gap.diagnose import calibrated, diagnose
from analysis.gap.look.arithmetic import OF_QUARTERS
from analysis.gap.measure.measured import measured
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, look
from sensor.camera_file import load
from sensor.colours import Colours
from sensor.effects.brighter_fatter import BrighterFatter
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.nonlinearity import Nonlinearity
from sensor.effects.read_noise import ReadNoise
from sensor.frames import Capture, Frames
from sensor.protocol import Shot
from sensor.record import record
from tests.short import HEIGHT, PROTOCOL, WIDTH, camera, light

pytestmark = pytest.mark.whole


def test_a_camera_quieter_than_a_step_is_calibrated() -> None:
    """Read noise of 0.2 DN and offsets of 0.17 DN, black near half a step: darks of two
    codes, whose moments are those of half the noise at another black level as well."""
    made = load("icx098").resized(HEIGHT, WIDTH)
    gain = 0.0185
    quiet = dataclasses.replace(made, gain_dn_per_e=Colours.of(gain), black_dn=4.35)
    quiet = quiet.plus(
        ReadNoise(reset_e=0.0, thermal_e=0.2 / gain, other_e=0.0), Fpn(sigma_e=0.17 / gain)
    )
    taken = record(quiet.with_body(3), PROTOCOL, {"lamp": light().rate_e_per_s}, seed=3)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    known = calibrated(setting, None)
    assert np.sqrt(known.base.read_dn2) == pytest.approx(0.2, rel=0.15)
    assert np.sqrt(known.base.fpn_dn2) == pytest.approx(0.17, rel=0.15)
    assert measured(known, setting.seen).whole.p_value > 0.01


@pytest.mark.parametrize("even", [True, False])
def test_light_that_was_read_from_the_frames_stays_as_bright_as_they_are(even: bool) -> None:
    """Charges that repel each other take a tenth off the variance of bright pixels: no gain fits
    dim and bright ones. A higher gain and less light would, where nothing tells how much light
    there is; but its frames do, to the noise of their mean, which is well below 1 %. So it is of
    pictures that are even, and of those that have an edge."""
    made = dataclasses.replace(
        camera().without(Demosaic),
        pixels="bayer16",
        bits=12,
        gain_dn_per_e=Colours.of(0.2),
        black_dn=70.0,
    ).plus(BrighterFatter(horizontal_per_e=3e-6, vertical_per_e=3e-6))
    flat = np.full((HEIGHT, WIDTH, 3), 6e5, dtype=np.float32)
    flat[:, : WIDTH // 2] *= 1.0 if even else 0.8
    levels = (0.2, 0.4, 0.7, 1.0)
    lit = tuple(Shot(label=f"flat {v}", light=("lamp",), level=(v,), exposure_s=0.02, frames=32)
                for v in levels)  # fmt: skip
    dark = dataclasses.replace(PROTOCOL.shot[0], frames=32)
    protocol = dataclasses.replace(PROTOCOL, shot=(dark, *lit))
    setting = look(record(made.with_body(6), protocol, {"lamp": flat}, seed=6), {})
    assert setting is not None
    base, light_of_frames = calibrated(setting, None).base, setting.scenery.light
    assert light_of_frames.known == even
    dn_per_s = base.gain_dn_per_e * base.level["lamp"] * light_of_frames.rates["lamp"].mean((0, 1))
    brightest = setting.capture.frames[-1].dn.mean() - 70.0
    assert dn_per_s.mean() * 0.02 == pytest.approx(brightest, rel=0.01)
    with_it = diagnose(setting.capture, suspects=[BrighterFatter, Nonlinearity]).report
    assert [e.name for e in with_it.effects] == ["brighter_fatter"]


def test_a_mosaic_that_begins_with_green_is_calibrated_colour_by_colour() -> None:
    """Gains differ by colour, and the light of each is that of the scene: level 1 in all three."""
    gains = Colours(R=0.015, G=0.02, B=0.026)
    made = dataclasses.replace(camera(), cfa="GBRG", gain_dn_per_e=gains)
    taken = record(made.with_body(4), PROTOCOL, {"lamp": light().rate_e_per_s}, seed=4)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    base = calibrated(setting, None).base
    assert base.channels == ("R", "G", "B")
    assert list(base.gain_dn_per_e) == pytest.approx(list(gains), rel=0.04)
    assert list(base.level["lamp"]) == pytest.approx([1.0] * 3, rel=0.04)


def another_program(
    rate: np.ndarray,
    shot: Shot,
    *,
    whole: bool,
    gains: tuple[float, ...] = (1.0, 1.0, 1.0),
    spread: float = 0.0,
    uneven: float = 0.0,
    clamp: float = 0.0,
    finer: Callable[[np.ndarray], np.ndarray] | None = None,
    steps: int = 16,
) -> np.ndarray:
    """The frames of a camera of equation (1) that is written in NumPy and shares no line with ours:
    gain 0.02 DN/e-, read noise 30 e-, dark current that moves the mean, of that `spread` over the
    photosites in e-/s, log-normal where it is `uneven`, and a clamp with noise in e-. A converter
    with finer `steps` is followed by gains about the black level and by `finer` to whole codes."""
    rng = np.random.default_rng([len(shot.label), int(whole)])
    body, black = np.random.default_rng(99), np.random.default_rng([len(shot.label), 98])
    prnu = 1 + 0.01 * body.normal(size=(HEIGHT, WIDTH))
    fpn = 8.0 * body.normal(size=(HEIGHT, WIDTH))
    normal = body.normal(size=(HEIGHT, WIDTH))
    v = np.log1p(uneven**2)
    law = (np.exp(np.sqrt(v) * normal - v / 2) - 1) / uneven if uneven else normal
    dark = 400.0 + spread * law
    red, green, blue = (np.zeros((HEIGHT, WIDTH)) for _ in range(3))
    red[::2, ::2] = green[::2, 1::2] = green[1::2, ::2] = blue[1::2, 1::2] = 1
    masks = (red, green, blue)
    level = 0.0 if shot.dark else shot.level[0]
    light = sum(rate[..., c] * masks[c] for c in range(3)) * level
    frames = []
    for _ in range(shot.frames):
        charge = rng.poisson((light * prnu + np.maximum(dark, 0.0)) * shot.exposure_s)
        dn = 0.02 * (charge + fpn + 30.0 * rng.normal(size=charge.shape)) + 6.3
        dn += 0.02 * clamp * black.normal()
        raw = (
            np.clip(np.round(dn), 0, 255)
            if whole
            else np.round(steps * dn) / steps
            if finer
            else dn
        )
        planes = []
        for mask in masks:
            cross = np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]]) / 4
            square = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 4
            kernel = cross if mask is green else square
            planes.append(ndimage.convolve(raw * mask, kernel, mode="mirror"))
        origin = 6.3 if finer else 0.0
        colours = origin + (np.stack(planes, axis=-1) - origin) * gains
        frames.append(np.clip((finer or np.round)(colours), 0, 255))
    return np.array(frames, dtype=np.uint8)


LONG_DARK = Shot(label="long dark", exposure_s=0.2, frames=16)


def of_another_program(*more: Shot, shading: np.ndarray | float = 1.0, **how: Any) -> Setting:
    """The short protocol and more shots by that camera, made ready; its light has a shading that
    nobody stated."""
    stacks = tuple(
        Frames(
            dn=another_program(light().rate_e_per_s * shading, shot, **how),
            shot=shot,
            pixels="rgb8",
            bits=8,
            cfa="RGGB",
        )
        for shot in (*PROTOCOL.shot, *more)
    )
    setting = look(Capture(camera="another", frames=stacks), {"lamp": light()})
    assert setting is not None
    return setting


@pytest.mark.parametrize("whole", [True, False])
def test_the_base_camera_of_another_program_is_matched(whole: bool) -> None:
    """It may count in whole numbers or in fractions, and its clamp may follow nothing: no gap, but
    for a base camera that counts in another way."""
    setting = of_another_program(LONG_DARK, whole=whole)
    assert setting.counting.arithmetic == (2 if whole else 0)
    found = measured(calibrated(setting, None), setting.seen).whole
    assert found.p_value > 1e-3, found
    counting = dataclasses.replace(setting.counting, arithmetic=3 if whole else 2)
    other = dataclasses.replace(setting, counting=counting)
    assert measured(calibrated(other, None), setting.seen).whole.p_value < 1e-6


HALVES = {"even": np.round, "up": lambda dn: np.floor(dn + 0.5)}


@pytest.mark.parametrize("halves", HALVES)
def test_a_converter_of_more_bits_than_leave_the_camera_is_part_of_the_base(halves: str) -> None:
    """Where halves go to the even number it has 17 sixteenths and its neighbours 15, and gains of
    sixteenths make combs of their own: no gap, but for a base camera that knows of neither. The
    gains come out to what moves no tooth of 200 codes by a step."""
    gains = (1.06, 1.0, 1.17)
    setting = of_another_program(LONG_DARK, whole=False, gains=gains, finer=HALVES[halves])
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 1e-3
    found = known.base.white_balance
    assert found is not None
    assert (found.red_gain, found.blue_gain) == pytest.approx((gains[0], gains[2]), abs=3e-4)
    plain = dataclasses.replace(
        known.base,
        arithmetic=0,
        white_balance=None,
        gain_dn_per_e=known.base.gain_dn_per_e * gains,
        read_dn2=known.base.read_dn2 * np.square(gains),
        fpn_dn2=known.base.fpn_dn2 * np.square(gains),
    )
    assert measured(around(plain, known.scenery), setting.seen).whole.p_value < 1e-6


def test_of_gains_that_codes_leave_open_the_twins_take_the_right_one() -> None:
    """One step in a code more or less is almost the same comb: 1.262 for 1.17, as if it were the
    likeliest. Alone it leaves no gap, as blue then has a gain of its own that is a sixteenth lower;
    with one converter for all colours, as each has 0.02 DN/e-, only the right one fits."""
    gains = (1.06, 1.0, 1.17)
    setting = of_another_program(LONG_DARK, whole=False, gains=gains, finer=np.round)
    told, *_ = setting.counting.gains
    balance = dataclasses.replace(told.white_balance, blue_gain=1.17 / (1 - 1.17 / 16))
    wrong = dataclasses.replace(told, white_balance=balance)
    counting = dataclasses.replace(setting.counting, gains=(wrong, told))
    known = calibrated(dataclasses.replace(setting, counting=counting), None)
    assert known.base.white_balance == told.white_balance
    alone = dataclasses.replace(setting.counting, gains=(wrong,))
    misled = calibrated(dataclasses.replace(setting, counting=alone), None)
    for fitted, ratio in ((known, 1.0), (misled, 15 / 16)):
        _, green, blue = fitted.base.gain_dn_per_e
        assert blue / green == pytest.approx(ratio, abs=0.02)


def test_a_converter_of_ten_bits_is_told_by_its_wide_and_narrow_codes() -> None:
    """5 quarters and 3 in turn, read from the histogram: no gap, but for a base camera that counts
    in fractions."""
    setting = of_another_program(LONG_DARK, whole=False, finer=np.round, steps=4)
    assert setting.counting.arithmetic == OF_QUARTERS
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 1e-3
    plain = dataclasses.replace(known.base, arithmetic=0)
    assert measured(around(plain, known.scenery), setting.seen).whole.p_value < 1e-6


def test_light_that_is_shaded_otherwise_than_was_stated_is_no_gap() -> None:
    """Calibration takes up a slope of 8 % from the middle to the side in the mean images. It moves
    patches by up to ten codes: histograms differ beyond doubt, but for twins that are lit as the
    frames show it."""
    shading = (1 + 0.08 * np.linspace(-1, 1, WIDTH))[:, None]
    setting = of_another_program(LONG_DARK, whole=False, shading=shading)
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 1e-3
    stated = dataclasses.replace(known.scenery.light, shown=None)
    by_it = around(known.base, dataclasses.replace(known.scenery, light=stated))
    assert measured(by_it, setting.seen).whole.p_by_family["codes"] < 1e-6


def test_light_that_is_tinted_over_the_field_is_no_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Red that falls by 2 % from one side to the other, and blue that rises: no gap, but where
    calibration knows of no such light."""
    slope = 0.01 * np.linspace(-1, 1, WIDTH)[None, :, None] * np.array([-1.0, 0.0, 1.0])
    setting = of_another_program(LONG_DARK, whole=False, shading=1.0 + slope)
    assert measured(calibrated(setting, None), setting.seen).whole.p_value > 1e-3
    monkeypatch.setattr(light_ways, "TINT_PRIOR", 1e-9)
    grey = measured(calibrated(setting, None), setting.seen).whole
    assert grey.p_by_family["mean image"] < 1e-6


def test_dark_current_that_differs_between_photosites_is_part_of_the_base() -> None:
    """100 e-/s more or less are 20 e- in 0.2 s, beside offsets of 8: no gap, but for a base camera
    whose photosites are alike. The spread is known to 1.5 % by these frames, and calibration ends
    where no more than chance is left: within a tenth."""
    spread = 100.0
    setting = of_another_program(LONG_DARK, whole=False, spread=spread)
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 1e-3
    assert np.sqrt(known.base.dark_spread2) == pytest.approx(spread, rel=0.1)
    alike = around(dataclasses.replace(known.base, dark_spread2=0.0), known.scenery)
    assert measured(alike, setting.seen).whole.p_value < 1e-6


def test_the_law_of_dark_currents_is_part_of_the_base() -> None:
    """Currents that are log-normal have no gap and come out with their skewness of 1.6, to a third
    of u; normal ones of the same spread come out without."""
    spread, uneven = 200.0, 0.5
    setting = of_another_program(LONG_DARK, whole=False, spread=spread, uneven=uneven)
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 1e-3
    assert np.sqrt(known.base.dark_spread2) == pytest.approx(spread, rel=0.1)
    assert known.base.dark_uneven == pytest.approx(uneven, rel=1 / 3)
    normal = calibrated(of_another_program(LONG_DARK, whole=False, spread=spread), None)
    assert normal.base.dark_uneven < uneven / 3


def test_noise_of_the_clamp_is_part_of_the_base() -> None:
    """A clamp that averages 400 black pixels of 30 e- has a noise of 1.5 e-: no gap, but for a base
    camera whose clamp has none, which calls it a drift. Three darks of 16 frames tell it to an
    eighth; what no clamp has, with fewer than 25 pixels, is not taken for one."""
    clamp = 1.5
    setting = of_another_program(LONG_DARK, whole=False, clamp=clamp)
    known = calibrated(setting, None)
    assert measured(known, setting.seen).whole.p_value > 1e-3
    assert np.sqrt(known.base.clamp_e2) == pytest.approx(clamp, rel=4 / 8)
    # all channels of a frame share it: where they are taken for so many witnesses it is lost
    assert known.base.clamp_e2 == pytest.approx(by_moments(setting)[1].clamp_e2, rel=0.05)
    still = around(dataclasses.replace(known.base, clamp_e2=0.0), known.scenery)
    assert measured(still, setting.seen).whole.p_value < 1e-6
    wild = calibrated(of_another_program(LONG_DARK, whole=False, clamp=15.0), None).base
    assert wild.clamp_e2 == 0.0


def test_a_white_balance_on_whole_codes_is_part_of_the_base() -> None:
    """Read from the comb it leaves, and matched; without it the base camera does not fit."""
    setting = of_another_program(whole=True, gains=(1.2, 1.0, 0.85))
    (gains,) = setting.counting.gains
    found = gains.white_balance
    assert (found.red_gain, found.blue_gain, found.about_black) == (1.2, 0.85, 0.0)
    assert measured(calibrated(setting, None), setting.seen).whole.p_value > 1e-3
    counting = dataclasses.replace(setting.counting, gains=())
    unread = dataclasses.replace(setting, counting=counting)
    assert measured(calibrated(unread, None), setting.seen).whole.p_value < 1e-6


def test_a_white_balance_on_whole_codes_of_a_mosaic_is_part_of_the_base() -> None:
    """Codes of red and blue sites are multiplied and rounded again, halves up: of a gain of 1.3
    that is every tenth code, by which twins tell where halves go."""
    made = dataclasses.replace(camera().without(Demosaic), pixels="bayer8")
    taken = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=4)
    gains = np.ones((HEIGHT, WIDTH))
    gains[::2, ::2], gains[1::2, 1::2] = 1.3, 1.45
    frames = tuple(
        dataclasses.replace(f, dn=np.clip(np.floor(f.dn * gains + 0.5), 0, 255).astype(np.uint8))
        for f in taken.frames
    )
    setting = look(dataclasses.replace(taken, frames=frames), {"lamp": light()})
    assert setting is not None
    found = calibrated(setting, None)
    balance = found.base.white_balance
    assert balance is not None
    assert (balance.red_gain, balance.blue_gain) == pytest.approx((1.3, 1.45), abs=1e-4)
    assert measured(found, setting.seen).whole.p_value > 1e-3
