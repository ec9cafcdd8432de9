"""A real capture in two halves: one to diagnose, one to score."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from camtruth.blind.format import TRUTH
from camtruth.blind.splitting import split
from foundation.verification import verify
from sensor import protocol
from sensor.capture_folder import read_capture
from tests.conftest import Run, Small


def test_halves_of_a_capture_share_no_frame(
    small: Small, small_capture: Path, tmp_path: Path
) -> None:
    whole = read_capture(small_capture)
    split(small_capture, tmp_path / "halves", run=2)
    halves = [read_capture(tmp_path / "halves" / name) for name in "ab"]
    for k, frames in enumerate(whole.frames):
        a, b = (np.asarray(half.frames[k].dn) for half in halves)
        assert len(a) == len(b) == 2  # of six frames, one run of two each; the rest has no partner
        np.testing.assert_array_equal(a, frames.dn[0:2])
        np.testing.assert_array_equal(b, frames.dn[2:4])
    assert halves[0].panels == whole.panels
    assert not list((tmp_path / "halves").rglob(TRUTH))
    assert (tmp_path / "halves" / "a" / "rate-incandescent.exr").exists()
    verify(tmp_path / "halves")
    assert protocol.load(str(small.protocol)).shot[0].label in {f.shot.label for f in whole.frames}


def test_a_split_by_exposures_refuses_a_single_dark(small_capture: Path, run: Run) -> None:
    said = run("blind", "split", small_capture, "--by", "exposures").complaint
    assert "one shot under no light" in said


def test_the_command_splits(small_capture: Path, run: Run) -> None:
    told = run("blind", "split", small_capture, "--json")
    assert told.code == 0, told.err
    halves = json.loads(told.out)["halves"]
    assert halves["a"] == halves["b"] == {"dark": 3, "half": 3, "full": 3}
