"""The worked example: what FFmpeg did to the frames is in what comes back, and nothing else is."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensor.capture_folder import read_capture
from tests.clusters import ROOT

pytest.importorskip("av")


def example(capture: Path, out: Path, setting: str) -> None:
    script = ROOT / "docs/examples/outside_program.py"
    subprocess.run(
        [sys.executable, str(script), str(capture), str(out), "--setting", setting],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
        capture_output=True,
    )


def test_nothing_is_nothing(small_capture: Path, tmp_path: Path) -> None:
    """The way out, through FFmpeg and in again leaves every pixel as it was."""
    example(small_capture, tmp_path / "out", "nothing")
    before, after = read_capture(small_capture), read_capture(tmp_path / "out/real")
    for a, b in zip(before.frames, after.frames, strict=True):
        assert np.array_equal(a.dn, b.dn)


NOISE = {
    "unsharp": (1.3, 9.0),  # what is sharpened is noisier
    "denoise": (0.1, 0.8),  # what is smoothed is less so: a Gaussian of 0.6 px, after a demosaicer
    "average": (0.3, 0.7),  # two frames averaged: half, and rounding
}
"""Temporal variance of red against what it was, between these."""


@pytest.mark.parametrize("setting", [*NOISE, "chroma"])
def test_the_setting_is_the_gap(setting: str, small_capture: Path, tmp_path: Path) -> None:
    example(small_capture, tmp_path / "out", setting)
    before, after = read_capture(small_capture), read_capture(tmp_path / "out/real")
    assert not (tmp_path / "out/real/truth.json").exists()
    for a, b in zip(before.frames, after.frames, strict=True):
        assert (a.shot, a.bits) == (b.shot, b.bits)
        assert a.dn.shape == b.dn.shape
    a, b = before.frames[1], after.frames[1]
    assert a.shot.label == "half"
    x, y = (np.asarray(f.dn, dtype=np.float64)[2:] for f in (a, b))
    clear = (x.max(axis=(0, 3)) < 220) & (x.min(axis=(0, 3)) > 8)  # far from either end
    assert clear.sum() > 2000
    shift = np.median((y - x).mean(axis=(0, 3))[clear])
    assert abs(shift) < 1.0, "no setting shifts the level by more than rounding"
    if setting == "chroma":  # a chroma that four pixels share leaves red the noise of the luma
        assert red_with_green(y, clear) > red_with_green(x, clear) + 0.2
        return
    after_red, before_red = (s[..., 0].var(axis=0, ddof=1)[clear].mean() for s in (y, x))
    change = after_red / before_red
    low, high = NOISE[setting]
    assert low < change < high


def red_with_green(stack: np.ndarray[Any, Any], where: np.ndarray[Any, Any]) -> float:
    """Correlation of the temporal noise of red and green."""
    noise = (stack - stack.mean(axis=0))[:, where]
    return float(np.corrcoef(noise[..., 0].ravel(), noise[..., 1].ravel())[0, 1])
