"""The diagnosis from end to end, on captures whose truth is known and which it does not read."""

from __future__ import annotations

import dataclasses
import functools
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from analysis.gap.diagnose import Diagnosis, diagnose
from analysis.gap.look.families import EVERY_SHOT, REPEATED_IN_PART
from analysis.gap.ready.ambient_light import lit_room
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.setting import look
from analysis.gap.report import NO_GAP, GapReport, Place
from analysis.gap.verdict.conclude import conclude
from analysis.gap.verdict.trust import OF_ONE_THAT_STANDS_OUT
from camtruth.report.gap import answer, page
from sensor.catalogue import catalogue, effects_from_file
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.ambient_light import AmbientLight
from sensor.effects.dark_current import DarkCurrent
from sensor.effects.row_noise import RowNoise
from sensor.errors import CaptureError
from sensor.frames import Capture
from sensor.protocol import Shot
from sensor.record import record
from tests.short import HEIGHT, PROTOCOL, WIDTH, camera, light

SUSPECTS = ("row_noise", "crosstalk", "temporal_filter", "column_fpn")
SIGMA_E = 6.0


@functools.cache
def capture(*, rows: bool) -> Capture:
    """Frames with or without row noise of 0.12 DN, a fifth of the read noise."""
    taken = camera().plus(RowNoise(sigma_e=SIGMA_E)) if rows else camera()
    rates = {"lamp": light().rate_e_per_s}
    return record(taken.with_body(21), PROTOCOL, rates, seed=21)


@functools.cache
def diagnosed(*, rows: bool, without: str = "") -> Diagnosis:
    """What is said of it."""
    kinds = [catalogue()[name] for name in SUSPECTS if name != without]
    return diagnose(capture(rows=rows), stated={"lamp": light()}, suspects=kinds)


def processed(process: Callable[[np.ndarray], np.ndarray]) -> Capture:
    """The capture without row noise, every frame through another program."""
    plain = capture(rows=False)
    frames = [
        dataclasses.replace(f, dn=np.stack([process(frame) for frame in f.dn]))
        for f in plain.frames
    ]
    return dataclasses.replace(plain, frames=tuple(frames))


def bent(frame: np.ndarray) -> np.ndarray:
    """A power of whole codes, about code 0."""
    return np.round(255 * (frame / 255.0) ** 0.8).astype(np.uint8)


def compressed(frame: np.ndarray) -> np.ndarray:
    """Written as JPEG with colours at half resolution, and read again."""
    packed = io.BytesIO()
    Image.fromarray(frame).save(packed, "JPEG", quality=92, subsampling="4:2:0")
    return np.asarray(Image.open(packed))


@pytest.mark.whole
@pytest.mark.parametrize(
    ("process", "name", "figures"),
    [
        (bent, "gamma", {"exponent": 0.8, "about_black": 0.0}),
        (compressed, "jpeg", {"quality": 92.0, "subsampling": 2.0}),
    ],
)
def test_what_whole_codes_tell_is_found_behind_strong_processing(
    process: Callable[[np.ndarray], np.ndarray], name: str, figures: dict[str, float]
) -> None:
    """The camera is calibrated with the curve or the codec in it, whatever it looked like without:
    its gain comes out as it went in, to 15 % or to 4.5 of the standard errors that the report
    states. The noise of red and blue is all but lost in colours at half resolution, so theirs is
    held to less."""
    kinds = [catalogue()[one] for one in (name, "veiling_glare", "sharpening")]
    found = diagnose(processed(process), stated={"lamp": light()}, suspects=kinds)
    named = found.report.effects[0]
    assert named.name == name, answer(found.report)
    assert named.probability > 0.5
    assert found.report.gap.shrink > 0.9
    for parameter, value in figures.items():
        assert named.parameters[parameter].value == pytest.approx(value, abs=2e-3)
    assert found.trail is not None
    red, green, blue = found.trail.models[-1].base.gain_dn_per_e
    error = found.report.calibration["gain"]["G"].se
    assert error is not None
    assert green == pytest.approx(0.02, abs=max(0.003, 4.5 * error))
    assert (red, blue) == pytest.approx((0.02, 0.02), rel=0.3)


def test_a_camera_like_the_model_is_matched() -> None:
    """No effect is named, and calibration finds what went in within five standard errors."""
    found = diagnosed(rows=False)
    assert found.report.verdict == "matched", answer(found.report)
    assert found.report.effects == ()
    truth = camera()
    gain = found.report.calibration["gain"]["G"]
    assert gain.se is not None
    assert abs(gain.value - truth.gain_dn_per_e.G) < 5 * gain.se
    read = found.report.calibration["read"]["G"]
    assert read.se is not None
    assert abs(read.value - 30.0 * 0.02) < 5 * read.se


@pytest.mark.whole
def test_light_of_a_colour_in_the_darks_is_told_from_dark_current() -> None:
    """By the colours of what darks gather; dark current of the same size has none."""
    protocol = dataclasses.replace(
        PROTOCOL, shot=(Shot(label="long dark", exposure_s=0.06, frames=16), *PROTOCOL.shot)
    )

    def told(effect: Effect) -> DirectReading | None:
        rates = {"lamp": light().rate_e_per_s}
        taken = record(camera().plus(effect).with_body(5), protocol, rates, seed=5)
        setting = look(taken, {"lamp": light()})
        assert setting is not None
        return lit_room(setting)

    room = Colours(R=8000.0, G=6000.0, B=4000.0)
    found = told(AmbientLight(rate_e_per_s=room))
    assert found is not None
    rate = found.hints["rate_e_per_s"]
    assert isinstance(rate, Colours)
    assert list(rate) == pytest.approx(list(room), rel=0.2)
    assert found.base is not None
    assert found.base.dark_e_per_s == 0.0
    assert found.hints["by_the_scene"] == 0.0
    assert told(DarkCurrent(mean_e_per_s=6000.0, spread=0.0)) is None

    shown = told(AmbientLight(rate_e_per_s=room, by_the_scene=1.0))
    assert shown is not None
    rate = shown.hints["rate_e_per_s"]
    assert isinstance(rate, Colours)
    assert list(rate) == pytest.approx(list(room), rel=0.2)
    assert shown.hints["by_the_scene"] == 1.0


def test_an_effect_is_named_with_its_strength() -> None:
    """Row noise by its name, its sigma within four standard errors, and the gap closes."""
    found = diagnosed(rows=True).report
    assert [effect.name for effect in found.effects] == ["row_noise"], answer(found)
    assert found.verdict in ("explained", "partly explained")
    sigma = found.effects[0].parameters["sigma_e"]
    assert sigma.se is not None
    assert abs(sigma.value - SIGMA_E) < 4 * sigma.se
    assert sigma.se < 0.1 * SIGMA_E
    assert found.gap.p_value_before < 1e-3 < found.gap.p_value_after
    assert found.candidates[0].name == "row_noise"
    assert found.candidates[0].gap == pytest.approx(found.gap.after)
    assert found.where[0].family in ("rows", "neighbours")
    # neighbours that go together are processing's more often, and here the suspect's own doing
    assert {"neighbours"} < {place.family for place in found.where}
    assert {place.stage for place in found.where[:3]} == {"readout"}


@pytest.mark.whole
def test_an_effect_without_a_name_is_not_blamed_on_another() -> None:
    """With row noise taken out of the suspects nothing is named, and the place is still right."""
    found = diagnosed(rows=True, without="row_noise").report
    assert found.verdict == "unexplained", answer(found)
    assert found.effects == ()
    assert all(suspect.probability < 0.5 for suspect in found.candidates)
    assert found.where[0].family in ("rows", "neighbours")
    assert found.next_capture


@pytest.mark.whole
def test_what_a_report_does_not_name_is_not_in_its_camera() -> None:
    """Three causes are none. The first of them is named by itself where it stands out: row noise
    closes all of the gap, and no other suspect a fifth of it."""
    found = diagnosed(rows=True)
    setting, trail = found.setting, found.trail
    assert setting is not None
    assert trail is not None
    assert trail.lead is not None
    base, *others = trail.models
    first, *left = trail.measured
    three = dataclasses.replace(
        trail,
        models=(base, *3 * others),
        measured=(first, *3 * left),
        choices=3 * trail.choices,
    )
    report, told = conclude(setting, dataclasses.replace(three, lead=None))
    assert report.verdict == "unexplained"
    assert told.models == (base,)
    report, told = conclude(setting, three)
    assert report.verdict == "partly explained"
    assert [(one.name, one.probability) for one in report.effects] == [
        ("row_noise", OF_ONE_THAT_STANDS_OUT)
    ]
    assert told is trail.lead


OWN = """
from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Striping(Effect):
    \"\"\"Every row is read with an offset of its own, new in every frame.\"\"\"

    name: ClassVar[str] = "striping"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 77
    reference: ClassVar[str] = "ours"
    height_e: float = parameter(
        4.0, unit="e-", minimum=0.0, maximum=500.0, identity=0.0, doc="standard deviation"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value + self.height_e * stream.normal(signal.shape[1], 1))
"""


@pytest.mark.whole
def test_a_users_own_effect_closes_the_gap_here_and_on_a_fresh_capture(tmp_path: Path) -> None:
    """With row noise taken out and the user's file in its place, its name is given; the camera that
    comes of it matches new frames of another body."""
    file = tmp_path / "striping.py"
    file.write_text(OWN)
    (striping,) = effects_from_file(file)
    kinds = [catalogue()[name] for name in SUSPECTS if name != "row_noise"]
    found = diagnose(capture(rows=True), stated={"lamp": light()}, suspects=[*kinds, striping])
    assert [effect.name for effect in found.report.effects] == ["striping"], answer(found.report)
    assert found.report.gap.shrink > 0.8
    taken = camera().plus(RowNoise(sigma_e=SIGMA_E)).with_body(22)
    fresh = record(taken, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=22)
    report = diagnose(fresh, found.camera, stated={"lamp": light()}, suspects=kinds).report
    assert report.verdict == "matched", answer(report)


def test_the_camera_that_is_written_has_what_was_found() -> None:
    """It is the calibrated one with the effect added, of the capture's format."""
    found = diagnosed(rows=True).camera
    assert found is not None
    assert found.get(RowNoise) is not None
    assert (found.width, found.height, found.pixels) == (WIDTH, HEIGHT, "rgb8")
    assert pytest.approx(0.02, rel=0.05) == found.gain_dn_per_e.G


@pytest.mark.parametrize(
    ("shot", "channel", "words"),
    [
        ("lit", "R", "“repeated rows” of shot lit, R (transport)"),
        (EVERY_SHOT, None, "“repeated rows” of every shot (transport)"),
    ],
)
def test_what_is_unexplained_is_said_to_lie_somewhere(
    shot: str, channel: str | None, words: str
) -> None:
    place = Place(
        family="time",
        statistic=REPEATED_IN_PART,
        stage="transport",
        channel=channel,
        shot=shot,
        panel=None,
        z=9.0,
        size=0.1,
        unit="1",
    )
    assert words in answer(GapReport(verdict="unexplained", gap=NO_GAP, where=(place,)))


def test_the_page_shows_the_answer() -> None:
    """One page with its pictures in it and no other file."""
    html = page(diagnosed(rows=True), "camtruth diagnose x")
    assert "row_noise" in html
    assert html.count("data:image/png") == 5
    assert "://" not in html.replace("http://www.w3.org", "")


@pytest.mark.parametrize("count", [1, 3])
def test_too_few_frames_are_said_to_be_too_few(count: int) -> None:
    """And how many it takes."""
    full = capture(rows=False)
    few = dataclasses.replace(
        full, frames=tuple(dataclasses.replace(f, dn=f.dn[:count]) for f in full.frames)
    )
    report = diagnose(few, stated={"lamp": light()}, suspects=[]).report
    assert report.verdict == "insufficient data"
    assert report.next_capture is not None
    assert "16" in report.next_capture


@pytest.mark.parametrize("value", [0, 255])
def test_frames_without_a_picture_are_no_data(value: int) -> None:
    """All black, and all saturated."""
    full = capture(rows=False)
    flat = tuple(
        f if f.shot.dark else dataclasses.replace(f, dn=np.full_like(f.dn, value))
        for f in full.frames
    )
    report = diagnose(dataclasses.replace(full, frames=flat), suspects=[]).report
    assert report.verdict == "insufficient data"


def test_another_scene_is_refused() -> None:
    """Frames upside down do not show the light that is stated."""
    full = capture(rows=False)
    turned = tuple(dataclasses.replace(f, dn=f.dn[:, ::-1].copy()) for f in full.frames)
    with pytest.raises(CaptureError, match="do not show"):
        diagnose(dataclasses.replace(full, frames=turned), stated={"lamp": light()}, suspects=[])
