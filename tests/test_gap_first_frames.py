"""What first frames lack: f A, f^2 A, and so on, of a step of light A."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from analysis.gap.diagnose import diagnose
from analysis.gap.look.first_frames import (
    FEWEST,
    LEFT_OUT,
    Beginning,
    beginning,
    without_beginnings,
)
from analysis.gap.report import NO_GAP, GapReport
from analysis.gap.verdict.first_frames import with_first_frames
from sensor.effects.image_lag import ImageLag
from sensor.effects.lamp_drift import LampDrift
from sensor.effects.row_noise import RowNoise
from sensor.frames import Capture, Frames
from sensor.protocol import Protocol, Shot
from sensor.record import record
from tests.short import PROTOCOL, camera, light

BLACK_DN, GAIN, SIDE = 100.0, 0.3, 64
SHARE = 0.04


def capture_of(
    share: float, *, follows: bool, first: float = 1.0, counts: int = 24, seed: int = 7
) -> Capture:
    """A grey camera whose photosites keep each electron with some probability, so that frames of
    steady light stay independent and Poisson; shots begin in the dark or follow each other, and
    the first frame of each may be exposed otherwise."""
    rng = np.random.default_rng(seed)
    stays = np.zeros((SIDE, SIDE), dtype=np.int64)
    stacks = []
    for label, rate_e in (("dark", 20.0), ("dim", 1500.0), ("bright", 6000.0), ("half", 3000.0)):
        stays = stays if follows else np.zeros_like(stays)
        dn = np.empty((counts, SIDE, SIDE), dtype=np.uint16)
        for k in range(counts):
            there = stays + rng.poisson(rate_e * (first if k == 0 else 1.0), stays.shape)
            stays = rng.binomial(there, share)
            noise = rng.normal(0, 3.0, stays.shape)
            dn[k] = np.round(BLACK_DN + GAIN * (there - stays) + noise)
        lit = label != "dark"
        shot = Shot(
            label=label,
            exposure_s=0.02,
            frames=counts,
            light=("lamp",) if lit else (),
            level=(1.0,) if lit else (),
        )
        stacks.append(Frames(dn=dn, shot=shot, pixels="mono16", bits=12))
    return Capture(camera="first frames", frames=tuple(stacks))


@pytest.mark.parametrize("follows", [False, True])
def test_a_share_that_stays_behind_is_told_by_first_frames(follows: bool) -> None:
    """To its standard error; of three seeds and two ways at 4.5 standard errors, one false alarm in
    20,000."""
    for seed in (7, 8, 9):
        found = beginning(capture_of(SHARE, follows=follows, seed=seed))
        assert found is not None
        assert found.share is not None
        assert found.share_se is not None
        assert found.share_se < 0.02 * SHARE
        assert abs(found.share - SHARE) < 4.5 * found.share_se
        assert found.from_dark is not follows
        assert found.chance < 1e-12


def test_a_first_frame_that_is_exposed_otherwise_leaves_nothing_behind() -> None:
    """It lacks as much of each shot as a share that stays behind would, and its second frame
    nothing of that share of the share."""
    found = beginning(capture_of(0.0, follows=False, first=1 - SHARE))
    assert found is not None
    assert found.shots == ("dim", "bright", "half")
    assert found.share is None


def test_steady_shots_and_a_lamp_that_warms_up_begin_as_they_go_on() -> None:
    """Ten scatters of 20 means have by Student's t a probability of 5e-9, and two of three shots
    would have to have them."""
    assert beginning(capture_of(0.0, follows=False)) is None
    shot = Shot(label="lit", light=("lamp",), level=(1.0,), exposure_s=0.02, frames=24)
    warm = record(
        camera().plus(LampDrift(change=0.3, time_constant_s=0.2)),
        Protocol(name="one", shot=(shot,)),
        {"lamp": light().rate_e_per_s},
    )
    assert beginning(warm) is None


def test_without_a_dark_no_share_of_the_whole_signal_is_told() -> None:
    """Nobody knows how much of what is there is light."""
    capture = capture_of(SHARE, follows=False)
    found = beginning(dataclasses.replace(capture, frames=capture.frames[1:]))
    assert found is not None
    assert found.share is None


def test_few_frames_tell_nothing() -> None:
    assert beginning(capture_of(SHARE, follows=False, counts=FEWEST - 1)) is None


def test_first_frames_are_left_out() -> None:
    capture = capture_of(SHARE, follows=False)
    rest = without_beginnings(capture)
    assert [f.count for f in rest.frames] == [24 - LEFT_OUT] * 4
    assert beginning(rest) is None


BEGINS = Beginning(
    shots=("dim", "bright"),
    off_dn=(-18.0, -70.0),
    z=(-40.0, -200.0),
    chance=1e-30,
    share=SHARE,
    share_se=1e-4,
)


def report(verdict: str) -> GapReport:
    return GapReport(verdict=verdict, gap=NO_GAP)


def test_where_all_other_frames_match_first_frames_decide() -> None:
    """They name the lag that they agree on, and else say where something is wrong."""
    lag = with_first_frames(report("matched"), BEGINS)
    assert (lag.verdict, [one.name for one in lag.effects]) == ("explained", ["image_lag"])
    figures = {name: one.value for name, one in lag.effects[0].parameters.items()}
    assert figures == {"fraction": SHARE, "by_chance": 1.0, "from_dark": 1.0}
    assert lag.gap.p_value_before == BEGINS.chance
    assert [place.shot for place in lag.where] == ["bright", "dim"]
    unknown = dataclasses.replace(BEGINS, share=None, share_se=None)
    other = with_first_frames(report("matched"), unknown)
    assert (other.verdict, other.effects) == ("unexplained", ())


@pytest.mark.parametrize(
    ("verdict", "begins"), [("matched", None), ("unexplained", BEGINS), ("explained", BEGINS)]
)
def test_elsewhere_they_are_a_note_at_most(verdict: str, begins: Any) -> None:
    before = report(verdict)
    after = with_first_frames(before, begins)
    assert after.verdict == verdict
    assert len(after.notes) == (begins is not None)


@pytest.mark.whole
def test_a_camera_with_the_lag_that_was_found_is_diagnosed_alike() -> None:
    """The whole way and back: of a camera whose shots begin in the dark, to four standard errors,
    and of the camera that was found, to five, which is 3.5 of the difference."""
    made = camera().plus(ImageLag(fraction=0.08, by_chance=1.0, from_dark=1.0))
    shares = []
    for seed in (1, 2):
        taken = record(made, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=seed)
        found = diagnose(taken, stated={"lamp": light()}, suspects=[ImageLag, RowNoise])
        assert (found.report.verdict, found.report.effects[0].name) == ("explained", "image_lag")
        shares.append(found.report.effects[0].parameters["fraction"])
        assert found.camera is not None
        made = found.camera
    assert shares[0].se is not None
    assert shares[0].value == pytest.approx(0.08, abs=4.0 * shares[0].se)
    assert shares[1].value == pytest.approx(shares[0].value, abs=5.0 * shares[0].se)
