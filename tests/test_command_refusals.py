"""Bad input: exit 2, nothing on standard output, one line that says what to do, nothing written."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Run, Small

REFUSED = {
    "unknown command": (("rendr",), "did you mean 'render'?"),
    "unknown option": (("measure", "x", "--jsn"), "did you mean '--json'?"),
    "unknown global option": (("--jsn",), "--help"),
    "missing argument": (("measure",), "CAPTURE"),
    "option without its value": (("render", "--lamp"), "--lamp"),
    "no number": (("roundtrip", "--seeds", "ten"), "--seeds"),
    "number out of range": (("roundtrip", "--seeds", "0"), "at least 1"),
    "negative seed": (("capture", "--seed", "-1"), "at least 0"),
    "unknown scene": (("render", "chrat"), "did you mean 'chart'?"),
    "unknown lamp": (("render", "--lamp", "incandecent"), "did you mean 'incandescent'?"),
    "unknown camera": (("capture", "--camera", "i40"), "did you mean 'i400'?"),
    "unknown protocol": (("capture", "papr"), "did you mean 'paper'?"),
    "unknown effect": (("effects", "fpm"), "did you mean 'fpn'?"),
    "unknown method": (("roundtrip", "--method", "irei"), "did you mean 'irie'?"),
    "unknown parameter": (("capture", "--with", "fpn.sigma=1"), "camtruth effects fpn"),
    "unknown effect to set": (("capture", "--with", "fpm.sigma_e=1"), "did you mean 'fpn'?"),
    "setting that is none": (("capture", "--with", "fpn"), "EFFECT.PARAMETER=NUMBER"),
    "parameter out of range": (("capture", "--with", "prnu.ratio=-1"), "expected 0 to"),
    "rate without a lamp": (("capture", "--rate", "x.exr"), "LAMP=FILE"),
    "rate of no lamp": (("capture", "--rate", "candle=x.exr"), "fluorescent"),
    "missing rate image": (("capture", "--rate", "fluorescent=x.exr"), "x.exr"),
    "missing capture": (("measure", "nowhere"), "capture.toml"),
    "no capture": (("measure", ""), "CAPTURE: it is empty"),
    "no output": (("capture", "--out", ""), "--out: it is empty"),
    "noise that is no number": (
        ("render", "--noise", "nan"),
        "expected a number of at least 1e-06",
    ),
    "infinite noise": (("capture", "--noise", "inf"), "expected a number of at least 1e-06"),
    "strength that is no number": (
        ("protocol", "recommend", "--strength", "nan"),
        "is not a number",
    ),
    "size that is no number": (("response", "--size", "nan"), "--size: nan is not a number"),
    "stray argument": (("doctor", "now"), "camtruth doctor --help"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case: str, run: Run, tmp_path: Path) -> None:
    words, remedy = REFUSED[case]
    assert remedy in run(*words).complaint
    assert list(tmp_path.iterdir()) == [], "something was written"


SCHEDULED = {
    "roundtrip": (),
    "study": ("gradient-quantization", "--overwrite", "--out", "kept"),
    "dataset make": ("spec.toml",),
    "blind make": ("set",),
    "blind solve": ("set",),
}


@pytest.mark.parametrize("command", SCHEDULED)
def test_a_scheduler_is_asked_before_there_is_work(command: str, run: Run, tmp_path: Path) -> None:
    """Before a render, before anything is overwritten, before its other arguments are looked at."""
    kept = tmp_path / "kept" / "results.jsonl"
    kept.parent.mkdir()
    kept.write_text("", encoding="utf-8")
    words = (*command.split(), *SCHEDULED[command], "--scheduler", "nonsense")
    assert "no answer from the scheduler nonsense" in run(*words).complaint
    assert [*tmp_path.rglob("*")] == [kept.parent, kept]


PROTOCOLS = {
    "negative exposure": ("exposure_s = 0.03268", "exposure_s = -1.0", "exposure_s"),
    "unknown key": ("exposure_s = 0.03268", "exposure = 0.03268", "did you mean 'exposure_s'?"),
    "unknown lamp": ('light = "incandescent"', 'light = "candle"', "fluorescent"),
    "two shots of one label": ('label = "half"', 'label = "full"', "rename"),
    "a label that is a path": ('label = "half"', 'label = "../half"', "label"),
    "not a number": ("exposure_s = 0.03268", "exposure_s = nan", "exposure_s"),
    "frames in quotes": ("frames = 6", 'frames = "6"', "expected a whole number"),
    "an exposure that is true": ("exposure_s = 0.03268", "exposure_s = true", "expected a number"),
}


@pytest.mark.parametrize("case", PROTOCOLS)
def test_refused_protocol(case: str, run: Run, small: Small, tmp_path: Path) -> None:
    old, new, remedy = PROTOCOLS[case]
    text = small.protocol.read_text(encoding="utf-8")
    file = tmp_path / "protocol.toml"
    file.write_text(text.replace(old, new), encoding="utf-8")
    assert remedy in run("capture", file, *small.words, "--out", "made").complaint
    assert list(tmp_path.iterdir()) == [file]


def test_a_protocol_without_shots(run: Run, small: Small, tmp_path: Path) -> None:
    file = tmp_path / "protocol.toml"
    for text, remedy in (("", "add shot = ..."), ("shot = []\n", "expected at least 1 of them")):
        file.write_text(f'name = "empty"\n{text}', encoding="utf-8")
        assert remedy in run("capture", file, *small.words, "--out", "made").complaint
    assert list(tmp_path.iterdir()) == [file]


def _panel_outside(folder: Path) -> None:
    manifest = folder / "capture.toml"
    text = re.sub(r"\bx = ", "x = 999", manifest.read_text(encoding="utf-8"))
    manifest.write_text(text, encoding="utf-8")


def _truncated(folder: Path) -> None:
    file = folder / "full.npy"
    file.write_bytes(file.read_bytes()[:-1000])


def _one_frame(folder: Path) -> None:
    np.save(folder / "full.npy", np.load(folder / "full.npy")[:1])


def _unequal(folder: Path) -> None:
    np.save(folder / "full.npy", np.load(folder / "full.npy")[:, :-2])


def _objects(folder: Path) -> None:
    np.save(folder / "full.npy", np.array([{}], dtype=object), allow_pickle=True)


def _lying(folder: Path) -> None:
    manifest = folder / "capture.toml"
    text = manifest.read_text(encoding="utf-8").replace('"rgb8"', '"mono8"')
    manifest.write_text(text, encoding="utf-8")


def _leaving(folder: Path) -> None:
    manifest = folder / "capture.toml"
    text = manifest.read_text(encoding="utf-8").replace('"full.npy"', '"../full.npy"')
    manifest.write_text(text, encoding="utf-8")


def _no_toml(folder: Path) -> None:
    (folder / "capture.toml").write_bytes(b"\x00\xff\x93NUMPY")


DAMAGE = (
    _panel_outside,
    _truncated,
    _one_frame,
    _unequal,
    _objects,
    _lying,
    _leaving,
    _no_toml,
)


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("as_json", [(), ("--json",)])
def test_refused_capture(
    damage: object, as_json: tuple[str, ...], run: Run, small_capture: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "damaged"
    shutil.copytree(small_capture, folder)
    assert callable(damage)
    damage(folder)
    assert run("measure", folder, *as_json).complaint


def test_truncated_rate_image(run: Run, small: Small, tmp_path: Path) -> None:
    file = tmp_path / "rate.exr"
    file.write_bytes(small.rate.read_bytes()[:-4000])
    words = ("--camera", small.camera, "--rate", f"incandescent={file}", "--out", "made")
    assert str(file) in run("capture", small.protocol, *words).complaint
    assert list(tmp_path.iterdir()) == [file]


def test_a_rate_image_cut_early_is_one_line(small: Small, tmp_path: Path) -> None:
    """OpenEXR complains from C: a process of its own shows all that reaches a person."""
    file = tmp_path / "rate.exr"
    content = small.rate.read_bytes()
    file.write_bytes(content[: len(content) // 3])
    program = "import sys; from camtruth.command import main; sys.exit(main())"
    words = ["capture", str(small.protocol), "--camera", str(small.camera)]
    made = subprocess.run(
        [sys.executable, "-c", program, *words, "--rate", f"incandescent={file}"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
    )
    assert (made.returncode, made.stdout) == (2, "")
    assert re.fullmatch(r"camtruth: error: [^\n]*\n", made.stderr), made.stderr


def test_rate_image_of_another_size(run: Run, small: Small) -> None:
    words = ("--camera", "i400", "--rate", f"incandescent={small.rate}")
    assert "160 x 120" in run("capture", small.protocol, *words).complaint


def test_output_that_is_taken(run: Run, small: Small, tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.mkdir()
    (taken / "mine.txt").write_text("keep", encoding="utf-8")
    words = ("capture", small.protocol, *small.words, "--out", taken)
    assert "--overwrite" in run(*words).complaint
    assert (taken / "mine.txt").read_text(encoding="utf-8") == "keep"
    assert run(*words, "--overwrite").code == 0
    assert not (taken / "mine.txt").exists()


def test_output_that_is_a_file(run: Run, small: Small, tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    for out in (file, file / "below", "/proc/nowhere/below", "a" * 300, "a" * 5000):
        assert "--out" in run("capture", small.protocol, *small.words, "--out", out).complaint


def test_names_that_are_too_long(run: Run, small: Small, small_capture: Path) -> None:
    name = "a" * 5000
    for words in (
        ("measure", name),
        ("measure", small_capture, "--method", f"{name}.py:mine"),
        ("diagnose", small_capture, "--out", name),
        ("export", small_capture, "--format", "npy", "--licence", "MIT", "--out", name),
        ("import", name),
        ("render", f"{name}.toml"),
        ("protocol", "recommend", "--out", name),
        ("capture", small.protocol, "--rate", f"incandescent={name}"),
    ):
        complaint = run(*words).complaint
        assert "too long" in complaint
        assert len(complaint) < 1000


def test_no_traceback_from_a_users_estimator(run: Run, small_capture: Path, tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("def mine(capture):\n    return 1 / 0\n", encoding="utf-8")
    line = run("measure", small_capture, "--method", f"{file}:mine").complaint
    assert "ZeroDivisionError" in line
    assert "line 2" in line


def test_a_fault_of_ours_is_one_line_too(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from camtruth.commands import doctor

    def broken() -> None:
        raise RuntimeError("first\nsecond")

    monkeypatch.setattr(doctor, "report", broken)
    answer = run("doctor")
    assert (answer.code, answer.out, answer.err.count("\n")) == (1, "", 1)
    assert "CAMTRUTH_DEBUG=1" in answer.err
    monkeypatch.setenv("CAMTRUTH_DEBUG", "1")
    with pytest.raises(RuntimeError):
        run("doctor")


def test_interrupted(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    from camtruth.commands import doctor

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(doctor, "report", interrupted)
    answer = run("doctor")
    assert (answer.code, answer.out, answer.err.count("\n")) == (130, "", 1)


def test_as_a_process(tmp_path: Path) -> None:
    """The exit code reaches the shell, and standard output stays empty."""
    program = "import sys; from camtruth.command import main; sys.exit(main())"
    result = subprocess.run(
        [sys.executable, "-c", program, "capture", "--camera", "i40"],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
    )
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.count("\n") == 1
