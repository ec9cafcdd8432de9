"""What the diagnosis reads from one frame after the other: beats of a lamp, and repeats."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from analysis.gap.look.repeats import fresh, partly_repeats, repeats
from analysis.gap.ready.hints import mains_hz
from sensor.frames import Frames
from sensor.protocol import Shot


def flickering(mains: float | None, frames: int = 24) -> Frames:
    """Noise of a lit shot at 15 frames a second, of which a lamp changes the mean by 1 %."""
    rng = np.random.default_rng(9)
    shot = Shot(
        label="lit", light=("lamp",), exposure_s=0.004, frames=frames, interval_s=INTERVAL_S
    )
    level = np.full(frames, 100.0)
    if mains is not None:
        level += np.sin(2 * np.pi * 2 * mains * np.arange(frames) * INTERVAL_S + 0.4)
    dn = np.round(level[:, None, None] + rng.normal(0, 2, (frames, 64, 64))).astype(np.uint8)
    return Frames(dn=dn, shot=shot, pixels="mono8", bits=8)


INTERVAL_S = 1 / 15


@pytest.mark.parametrize("mains", [50.0, 60.3, 48.76])
def test_the_mains_is_read_from_the_beat_of_the_means(mains: float) -> None:
    """Beats are known to a part of a cycle over the stack, and in either direction."""
    found = mains_hz([flickering(mains)])
    assert found is not None
    beat = [2 * f * INTERVAL_S % 1.0 for f in (found, mains)]
    same = min(abs(beat[0] - beat[1]), abs(beat[0] + beat[1] - 1.0))
    assert same < 0.25 / 24
    assert min(abs(found - 50), abs(found - 60)) <= min(abs(mains - 50), abs(mains - 60)) + 0.1


def test_a_beat_that_the_exposure_averages_away_is_of_another_mains() -> None:
    """A hundredth of a second is one half cycle of 50 Hz. Of 49.72 Hz it leaves sinc 0.9944 =
    0.0056 of two thirds: no lamp there beats by a hundredth. As many half cycles a frame below the
    next whole number, at 47.78 Hz, it beats alike, and a quarter of that depth is enough."""
    dn = flickering(49.72)
    shot = dataclasses.replace(dn.shot, exposure_s=0.01)
    found = mains_hz([dataclasses.replace(dn, shot=shot)])
    assert found == pytest.approx(6.5 / INTERVAL_S - 49.72, abs=0.25 / 24 / INTERVAL_S)


def test_noise_has_no_beat() -> None:
    assert mains_hz([flickering(None)]) is None
    assert mains_hz([]) is None


def test_repeats_are_left_out_and_the_first_frames_stand_in_for_them() -> None:
    dn = np.arange(5, dtype=np.uint8)[[0, 1, 1, 2, 3, 3, 3, 4], None, None]
    assert repeats(dn).tolist() == [False, False, True, False, False, True, True, False]
    assert fresh(dn, 7).ravel().tolist() == [0, 1, 2, 3, 4, 0, 1]
    assert fresh(dn[[0, 1, 3]], 2).ravel().tolist() == [0, 1]


@pytest.mark.parametrize("shape", [(12, 48, 96), (12, 48, 96, 3)])
def test_a_frame_that_repeats_rows_of_the_one_before_is_told_from_one_that_is_all_the_same(
    shape: tuple[int, ...],
) -> None:
    """Torn frames have the lower rows of the frame before, late fields its odd ones. A border that
    never changes is in every frame, and a frame that repeats all of the one before is counted as
    such."""
    dn = np.random.default_rng(5).normal(40.0, 0.7, shape).round().astype(np.uint8)
    dn[:, :4] = np.arange(96, dtype=np.uint8).reshape(1, 1, 96, *(1,) * (len(shape) - 3))
    assert not partly_repeats(dn).any()
    dn[3, 30:] = dn[2, 30:]
    dn[7, 1::2] = dn[6, 1::2]
    dn[10] = dn[9]
    assert np.flatnonzero(partly_repeats(dn)).tolist() == [3, 7]


def test_rows_that_hardly_change_are_no_witnesses() -> None:
    """A row of a dark that is clipped at its black level, where one pixel is hot, changes by that
    pixel alone and repeats in many frames."""
    dn = np.zeros((40, 48, 96), dtype=np.uint8)
    dn[:, :, 50] = np.random.default_rng(6).integers(3, 5, (40, 48))
    assert not partly_repeats(dn).any()
