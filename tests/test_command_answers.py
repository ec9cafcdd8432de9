"""What the commands answer when all is well: files, tables, JSON alone on standard output."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from analysis.methods import method_names
from analysis.parameters import PAPER_KEYS
from camtruth.command import Commands
from foundation.output import CHECKSUMS, sha256
from tests.conftest import Run, Small

COMMANDS = sorted(Commands().files())
START_S = 0.3
"""A command line that only explains itself answers within this, on an idle machine."""


def test_help_lists_every_command(run: Run) -> None:
    text = run("--help").out
    assert {"demo", "render", "capture", "measure", "roundtrip", "effects", "doctor"} <= set(
        COMMANDS
    )
    for name in COMMANDS:
        assert re.search(rf"^  {name} +\S", text, re.MULTILINE), name


def test_the_package_is_the_command() -> None:
    def answer(*words: str) -> tuple[int, str, str]:
        done = subprocess.run(
            [sys.executable, "-m", "camtruth", *words], capture_output=True, text=True, check=False
        )
        return done.returncode, done.stdout, done.stderr

    code, out, err = answer("--help")
    assert (code, err) == (0, "")
    assert out.startswith("Usage: camtruth ")
    code, out, err = answer("nonsense")
    assert (code, out, err.count("\n")) == (2, "", 1)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command: str, run: Run) -> None:
    answer = run(command, "--help")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"Usage: camtruth {command}")


@pytest.mark.parametrize("command", ["--help", "capture --help", "measure --help"])
def test_help_reads_nothing_heavy(command: str) -> None:
    """What reads mitsuba or colour-science takes over a second; help may not."""
    program = (
        "import sys; from camtruth.command import main; main(sys.argv[1:]);"
        "heavy = {'mitsuba', 'drjit', 'colour', 'numpy', 'scipy'} & set(sys.modules);"
        "assert not heavy, heavy"
    )
    root = Path(__file__).parents[1]
    words = [sys.executable, "-c", program, *command.split()]
    started = time.perf_counter()
    subprocess.run(words, check=True, capture_output=True, cwd=root)
    first = time.perf_counter() - started
    started = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import click"], check=True, cwd=root)
    bare = time.perf_counter() - started
    assert first < START_S + 2 * bare


def test_doctor(run: Run) -> None:
    document = json.loads(run("doctor", "--json").out)
    works = {entry["name"]: entry["works"] for entry in document["backends"]}
    assert works["scalar"]
    assert works[document["used"]]
    assert all(entry["remedy"] for entry in document["backends"] if not entry["works"])
    text = run("doctor").out
    for name in works:
        assert name in text


def test_effects(run: Run) -> None:
    entries = json.loads(run("effects", "--json").out)["effects"]
    assert {e["name"] for e in entries if e["base"]} == {
        "prnu",
        "dark_shot",
        "photon_shot",
        "fpn",
        "read_noise",
        "demosaic",
        "quantization",
    }
    keys = {"name", "unit", "default", "min", "max"}
    for entry in entries:
        assert {"name", "stage", "base", "parameters", "reference"} <= entry.keys()
        for parameter in entry["parameters"]:
            assert keys <= parameter.keys()
            assert parameter["min"] <= parameter["default"] <= parameter["max"]
    (one,) = json.loads(run("effects", "fpn", "--json").out)["effects"]
    assert one in entries
    assert "sigma_e" in run("effects", "fpn").out
    text = run("effects").out
    assert all(entry["name"] in text for entry in entries)


def test_render_reaches_the_noise_it_is_asked_for(run: Run, small: Small) -> None:
    from PIL import Image

    from render.rate import read_rate
    from scenes.scene import load

    answer = run("render", "--lamp", "incandescent", "--samples", "16", "--noise", "1e-3")
    assert answer.code == 0
    folder = Path("camtruth-out/render")
    assert {p.name for p in folder.iterdir()} == {
        "rate-incandescent.exr",
        "rate-incandescent.png",
        "shading-incandescent.svg",
        CHECKSUMS,
    }
    image = read_rate(folder / "rate-incandescent.exr")
    assert max(image.header.noise.values()) <= 1e-3
    assert image.header.scene == load("chart").name
    with Image.open(folder / "rate-incandescent.png") as preview:
        assert preview.size == image.rate_e_per_s.shape[1::-1]


def test_capture_folder(small_capture: Path) -> None:
    from sensor.capture_folder import read_capture

    files = {p.name for p in small_capture.iterdir()}
    assert files == {
        "capture.toml",
        "truth.json",
        "rate-incandescent.exr",
        "dark.npy",
        "half.npy",
        "full.npy",
        CHECKSUMS,
    }
    capture = read_capture(small_capture)
    assert [f.shot.label for f in capture.frames] == ["dark", "half", "full"]
    assert {p.name for p in capture.panels} == {"19", "20", "21", "22", "23", "24"}
    truth = json.loads((small_capture / "truth.json").read_text(encoding="utf-8"))
    assert truth["format"] == "camtruth-truth/1"
    assert truth["seed"] == 3
    assert set(truth["noise"]) == {"R", "G", "B"}


def test_checksums_are_true(small_capture: Path) -> None:
    lines = (small_capture / CHECKSUMS).read_text(encoding="utf-8").splitlines()
    listed = dict(reversed(line.split("  ")) for line in lines)
    assert set(listed) == {p.name for p in small_capture.iterdir()} - {CHECKSUMS}
    assert all(sha256(small_capture / name) == digest for name, digest in listed.items())


def test_the_same_seed_gives_the_same_capture(
    run: Run, small: Small, small_capture: Path, tmp_path: Path
) -> None:
    words = ("capture", small.protocol, *small.words)
    run(*words, "--seed", "3", "--out", "same")
    run(*words, "--seed", "4", "--out", "other")
    run(*words, "--seed", "3", "--body-seed", "1", "--out", "body")
    first = np.load(small_capture / "full.npy")
    assert np.array_equal(first, np.load(tmp_path / "same/full.npy"))
    assert not np.array_equal(first, np.load(tmp_path / "other/full.npy"))
    assert not np.array_equal(first, np.load(tmp_path / "body/full.npy"))


def test_a_setting_reaches_frames_and_truth(run: Run, small: Small, tmp_path: Path) -> None:
    words = ("capture", small.protocol, *small.words)
    for name, sigma_e in (("quiet", 0), ("loud", 300)):
        parts = [("reset_e", 0), ("thermal_e", sigma_e), ("other_e", 0)]
        settings = [w for p, v in parts for w in ("--with", f"read_noise.{p}={v}")]
        assert run(*words, *settings, "--out", name).code == 0
    noise = {n: np.load(tmp_path / n / "dark.npy").std() for n in ("quiet", "loud")}
    assert noise["loud"] > 5 * noise["quiet"]
    truth = json.loads((tmp_path / "loud/truth.json").read_text(encoding="utf-8"))
    read = next(e for e in truth["effects"] if e["name"] == "read_noise")
    assert read["parameters"]["thermal_e"] == {"value": 300.0, "unit": "e-"}


def test_a_capture_of_darks_alone_needs_no_light(run: Run, small: Small, tmp_path: Path) -> None:
    protocol = tmp_path / "darks.toml"
    protocol.write_text('name = "d"\n[[shot]]\nlabel = "d"\nexposure_s = 0.01\nframes = 2\n')
    assert run("capture", protocol, "--out", "darks").code == 0
    assert not list((tmp_path / "darks").glob("*.exr"))


@pytest.mark.parametrize("method", method_names())
def test_every_method_answers_every_key(method: str, run: Run, small_capture: Path) -> None:
    document = json.loads(run("measure", small_capture, "--method", method, "--json").out)
    for channel, findings in document["channels"].items():
        assert set(PAPER_KEYS) <= set(findings), channel
        if method in ("corrected", "emva1288"):
            assert {"gain", "dsnu", "prnu"} <= set(findings), channel
        for key, finding in findings.items():
            absent = finding["value"] is None
            assert set(finding) == ({"value", "reason"} if absent else {"value", "se", "unit"}), key


def test_measure_json_stands_alone(run: Run, small_capture: Path) -> None:
    answer = run("measure", small_capture, "--json")
    assert answer.code == 0
    document = json.loads(answer.out)
    assert document["format"] == "camtruth-noise/1"
    assert document["method"] == "irie"
    for table in document["channels"].values():
        for finding in table.values():
            assert set(finding) in ({"value", "se", "unit"}, {"value", "reason"})
    text = run("measure", small_capture).out
    assert all(key in text for key in document["channels"]["R"])


def test_measure_never_reads_truth_rate_or_scene(
    run: Run, small_capture: Path, tmp_path: Path
) -> None:
    """Frames alone: without truth, rates and scene the answer is the same to the last digit."""
    bare = tmp_path / "bare"
    bare.mkdir()
    for file in small_capture.glob("*.npy"):
        shutil.copy(file, bare)
    lines = (small_capture / "capture.toml").read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if not re.match(r"\s*(rate|scene) =", line)]
    assert len(kept) < len(lines)
    (bare / "capture.toml").write_text("\n".join(kept), encoding="utf-8")
    assert run("measure", bare, "--json").out == run("measure", small_capture, "--json").out


def test_measure_with_a_users_estimator(run: Run, small_capture: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "from analysis.parameters import Estimate, NoiseParameters\n"
        "def mine(capture):\n"
        "    read = Estimate(value=1.0, se=0.5, unit='DN')\n"
        "    return NoiseParameters(method='mine', channels={'R': {'read': read}})\n",
        encoding="utf-8",
    )
    document = json.loads(run("measure", small_capture, "--method", "mine.py:mine", "--json").out)
    assert document["method"] == "mine"
    assert document["channels"]["R"]["read"] == {"value": 1.0, "se": 0.5, "unit": "DN"}


def test_roundtrip(run: Run, small: Small) -> None:
    words = ("roundtrip", "--protocol", small.protocol, *small.words, "--seeds", "3")
    answer = run(*words, "--json")
    assert answer.code == 0
    document = json.loads(answer.out)
    assert document["format"] == "camtruth-roundtrip/1"
    assert document["seeds"] == 3
    keys = {"parameter", "channel", "method", "unit", "truth", "estimate", "bias", "bias_se"}
    keys |= {"rms", "coverage"}
    for row in document["rows"]:
        assert keys <= row.keys()
    from analysis.parameters import PAPER_KEYS

    reported = {(row["parameter"], row["channel"]) for row in document["rows"]}
    assert reported == {(key, channel) for key in PAPER_KEYS for channel in "RGB"}
    assert "read" in run(*words).out
