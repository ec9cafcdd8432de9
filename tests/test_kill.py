"""`kill -9` while a command writes: nothing half-written shows, and the command given again ends
with the bytes of a run that nobody disturbed. A disk that fills up is the same but says why.

A few moments here; CAMTRUTH_NIGHTLY=1 tries every format, at more moments.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from foundation.output import CHECKSUMS
from foundation.scratch import MARK
from foundation.verification import verify
from tests.clusters import ROOT
from tests.conftest import Run, Small

NIGHTLY = bool(os.environ.get("CAMTRUTH_NIGHTLY"))
MOMENTS = (1, 2, 3) if NIGHTLY else (1,)
"""How many files stand in the scratch folder when the blow falls."""

FORMATS = (
    ("png", "tiff", "tiff-pages", "fits", "npy", "zarr", "ffv1", "emva1288", "exr")
    if NIGHTLY
    else ("png", "zarr", "ffv1")
)
LONG = ("demo", "reproduce") if NIGHTLY else ()
TIMED = b"  report.html"
"""The report of the demo says how many seconds it took, so its bytes are its own."""

PATIENCE_S = 120
PROGRAM = "import sys; from camtruth.command import main; sys.exit(main())"


@pytest.fixture(scope="module")
def slow(small: Small, tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[str, ...]]:
    """Command lines that write for a second or more, by what they are."""
    from camtruth.command import main

    folder = tmp_path_factory.mktemp("slow")
    protocol = folder / "protocol.toml"
    long = small.protocol.read_text().replace("frames = 6", "frames = 150")
    protocol.write_text(long)
    capture = ("capture", str(protocol), *small.words, "--seed", "3")
    assert main([*capture, "--out", str(folder / "made")]) == 0
    scene = ROOT / "scenes/presets/chart.toml"
    (folder / "scene.toml").write_text(
        scene.read_text()
        .replace("width_px = 640", "width_px = 96")
        .replace("height_px = 480", "height_px = 72")
        .replace("pitch_um = 5.6", "pitch_um = 37.333333333333336")
    )
    lines = {
        "capture": capture,
        "render": ("render", str(folder / "scene.toml"), "--samples", "64"),
        "import": ("import", str(folder / "made")),
    }
    for name in LONG:
        lines[name] = (name, "--samples", "4", "--seeds", "2")
    for name in FORMATS:
        lines[f"export {name}"] = ("export", str(folder / "made"), "--format", name)
    return lines


CASES = ("capture", "render", "import", *LONG, *(f"export {name}" for name in FORMATS))


def begun(words: tuple[str, ...], out: Path, least: Callable[[], None] | None = None) -> Begun:
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words, "--out", str(out)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=least,
    )


Begun = subprocess.Popen[bytes]


def files_in_scratch(folder: Path) -> int:
    return sum(
        1 for made in folder.glob(f".*{MARK}*") for path in made.rglob("*") if path.is_file()
    )


def sums(folder: Path, words: tuple[str, ...]) -> list[bytes]:
    lines = (folder / CHECKSUMS).read_bytes().splitlines()
    return [line for line in lines if words[0] != "demo" or not line.endswith(TIMED)]


@pytest.mark.parametrize("case", CASES)
def test_killed_and_given_again(
    case: str, slow: dict[str, tuple[str, ...]], run: Run, tmp_path: Path
) -> None:
    words = slow[case]
    assert run(*words, "--out", tmp_path / "whole").code == 0
    expected = sums(tmp_path / "whole", words)
    struck = 0
    for moment in MOMENTS:
        folder = tmp_path / f"at-{moment}"
        folder.mkdir()
        out = folder / "made"
        process = begun(words, out)
        until = time.monotonic() + PATIENCE_S
        while files_in_scratch(folder) < moment and process.poll() is None:
            assert time.monotonic() < until
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        if process.returncode == -signal.SIGKILL and not out.exists():
            struck += 1
            assert list(folder.iterdir()), "it was writing"
            assert run(*words, "--out", out).code == 0
        assert sums(out, words) == expected
        verify(out)
        assert [path.name for path in folder.iterdir()] == ["made"], "and swept up"
    assert struck, "no blow fell while it was writing"


@pytest.mark.parametrize("case", ["capture", "export zarr", "import"])
def test_a_disk_that_fills_up_is_one_line_and_leaves_nothing(
    case: str, slow: dict[str, tuple[str, ...]], tmp_path: Path
) -> None:
    """A limit on the size of a file stands in for the disk: writes beyond it fail alike."""

    def little_room() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    process = begun(slow[case], tmp_path / "made", little_room)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, out) == (2, b""), err
    assert err.startswith(b"camtruth: error: cannot write")
    assert err.count(b"\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_scratch_of_the_living_is_left_alone(tmp_path: Path) -> None:
    from foundation.output import new_folder

    with new_folder(tmp_path / "made") as first:
        np.save(first / "a.npy", np.zeros(3))
        with new_folder(tmp_path / "made") as second:
            assert first.exists()
            np.save(second / "a.npy", np.zeros(3))
        (tmp_path / "made" / "a.npy").unlink()
        (tmp_path / "made" / CHECKSUMS).unlink()
    assert (tmp_path / "made" / "a.npy").exists()
    hidden = tmp_path / ".made-mine"
    hidden.mkdir()
    with new_folder(tmp_path / "made", overwrite=True):
        pass
    assert hidden.exists(), "what others hide is not ours"
