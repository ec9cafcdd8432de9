"""`kill -9` while a command writes: nothing half-written shows, and the command given again ends
with the bytes of a run that nobody disturbed. What takes long goes on by --resume, and redoes only
what is missing. A disk that fills up is the same but says why.

A few moments here; CAMTRUTH_NIGHTLY=1 tries every format, at more moments.
"""

from __future__ import annotations

import functools
import os
import resource
import shutil
import signal
from pathlib import Path

import numpy as np
import pytest

from foundation.output import CHECKSUMS
from foundation.resumable import unfinished
from foundation.scratch import MARK
from foundation.verification import verify
from tests.clusters import ROOT
from tests.conftest import Run, Small
from tests.killing import PATIENCE_S, begun, kill_once, standing

NIGHTLY = bool(os.environ.get("CAMTRUTH_NIGHTLY"))
MOMENTS = (1, 2, 3) if NIGHTLY else (1,)
"""How many files stand in the scratch folder when the blow falls."""

FORMATS = (
    ("png", "tiff", "tiff-pages", "dng", "fits", "npy", "zarr", "ffv1", "emva1288", "exr")
    if NIGHTLY
    else ("png", "zarr", "ffv1")
)
LONG = ("demo", "reproduce") if NIGHTLY else ()
TIMED = b"  report.html"
"""The report of the demo says how many seconds it took, so its bytes are its own."""

JOURNAL = "results.jsonl"
PIECES = (".npy", ".png", ".tif", ".dng", ".fits", ".mkv", ".exr", ".json")
"""Endings of the files that are written one by one; a Zarr array has its zarr.json."""


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
    for name in set(FORMATS) - {"dng"}:
        lines[f"export {name}"] = ("export", str(folder / "made"), "--format", name)
    lines["export dng"] = ("export", str(_raw(folder)), "--format", "dng")
    lines["study"] = ("study", "gradient-quantization", "--seeds", "2", "--cells", "4")
    return lines


def _raw(folder: Path) -> Path:
    """A capture of grey frames, told to be a mosaic: DNG holds nothing else."""
    made = folder / "raw"
    made.mkdir()
    stack = np.random.default_rng(1).integers(0, 255, (300, 120, 160), dtype=np.uint8)
    np.save(made / "lit.npy", stack)
    (made / "capture.toml").write_text(
        'format = "camtruth-capture/1"\ncamera = "x"\npixels = "bayer8"\nbits = 8\ncfa = "RGGB"\n'
        '[[shot]]\nlabel = "lit"\nlight = "lamp"\nexposure_s = 0.01\nframes = "lit.npy"\n'
    )
    return made


CASES = ("capture", "render", *LONG)
RESUMED = ("study", "import", *(f"export {name}" for name in FORMATS))


def files_in_scratch(folder: Path) -> int:
    return sum(len(standing(made)) for made in folder.glob(f".*{MARK}*"))


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
        kill_once(process, moment, functools.partial(files_in_scratch, folder))
        if process.returncode == -signal.SIGKILL and not out.exists():
            struck += 1
            assert list(folder.iterdir()), "it was writing"
            assert run(*words, "--out", out).code == 0
        assert sums(out, words) == expected
        verify(out)
        assert [path.name for path in folder.iterdir()] == ["made"], "and swept up"
    assert struck, "no blow fell while it was writing"


def done(out: Path) -> dict[str, tuple[int, int]]:
    """The pieces that stand in an unfinished folder, and which files they are.

    What is being made has a name that begins with a dot, itself or a folder that it lies in:
    it does not stand yet. Of a study, which keeps results as they come, the lines that hold one.
    """
    if (out / JOURNAL).exists():
        lines = (out / JOURNAL).read_bytes().splitlines(keepends=True)[1:]
        return {line.decode(): (0, 0) for line in lines if line.endswith(b"\n")}
    return {
        name.as_posix(): (file.st_ino, file.st_mtime_ns)
        for work in (unfinished(out), out)
        for path, file in standing(work).items()
        for name in [path.relative_to(work)]
        if path.suffix in PIECES and not any(part.startswith(".") for part in name.parts)
    }


@pytest.mark.parametrize("case", RESUMED)
def test_killed_and_resumed(
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
        kill_once(process, moment, lambda out=out: len(done(out)))
        if not (out / CHECKSUMS).exists():
            struck += process.returncode == -signal.SIGKILL
            stood = done(out)
            again = run(*words, "--out", out).complaint
            assert ("--overwrite" if case == "study" else "--resume") in again
            assert run(*words, "--out", out, "--resume").code == 0
            assert stood.items() <= done(out).items(), "what stood there was not made again"
        assert sums(out, words) == expected
        verify(out)
        assert [path.name for path in folder.iterdir()] == ["made"], "and swept up"
    assert struck, "no blow fell while it was writing"


@pytest.mark.parametrize("case", ["export png", "import"])
def test_a_run_of_another_question_is_not_continued(
    case: str, slow: dict[str, tuple[str, ...]], run: Run, tmp_path: Path
) -> None:
    """Other options, and frames that were changed meanwhile."""
    copy = tmp_path / "copy"
    shutil.copytree(slow[case][1], copy)
    words = (slow[case][0], str(copy), *slow[case][2:])
    out = tmp_path / "made"
    process = begun(words, out)
    kill_once(process, 1, lambda: len(done(out)))
    assert unfinished(out).exists()
    other = ("--licence", "MIT") if words[0] == "export" else ("--camera", "another")
    assert "another question" in run(*words, *other, "--out", out, "--resume").complaint
    os.utime(next(copy.glob("*.npy")), (1, 1))
    assert "another question" in run(*words, "--out", out, "--resume").complaint
    assert run(*words, "--out", out, "--overwrite").code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["copy", "made"]


def test_frames_that_are_refused_leave_nothing(run: Run, tmp_path: Path) -> None:
    """They can only be mended, and then there is nothing to go on with."""
    folder = tmp_path / "frames"
    folder.mkdir()
    for k in range(2):
        np.save(folder / f"{k}.npy", np.full((2, 8, 8 + k), 7, dtype=np.uint8))
    words = ("--light", "*=lamp", "--exposure", "*=0.1", "--camera", "x", "--cfa", "none")
    said = run("import", folder, *words, "--out", tmp_path / "made").complaint
    assert "one size and kind" in said
    assert [path.name for path in tmp_path.iterdir()] == ["frames"]


@pytest.mark.parametrize("case", ["capture", "export zarr", "import"])
def test_a_disk_that_fills_up_is_one_line_and_leaves_nothing_half_written(
    case: str, slow: dict[str, tuple[str, ...]], run: Run, tmp_path: Path
) -> None:
    """A limit on the size of a file stands in for the disk: writes beyond it fail alike.

    With room made, what can be resumed is.
    """

    def little_room() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    process = begun(slow[case], tmp_path / "made", little_room)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, out) == (2, b""), err
    assert err.startswith(b"camtruth: error: cannot write")
    assert err.count(b"\n") == 1
    if case == "capture":
        assert list(tmp_path.iterdir()) == []
        return
    assert b"--resume" in err
    assert [path.name for path in tmp_path.iterdir()] == ["made.unfinished"]
    assert run(*slow[case], "--out", tmp_path / "made", "--resume").code == 0
    assert run(*slow[case], "--out", tmp_path / "whole").code == 0
    assert sums(tmp_path / "made", slow[case]) == sums(tmp_path / "whole", slow[case])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["made", "whole"]


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
