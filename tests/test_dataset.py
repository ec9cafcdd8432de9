"""A dataset is the same bytes from one thread, all cores, or a cluster that loses a worker; and
from a run that was killed and went on."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from camtruth.dataset.make import make
from camtruth.dataset.plan import plan
from camtruth.dataset.spec import read_spec
from foundation.output import CHECKSUMS
from foundation.resumable import LOCK, unfinished
from foundation.verification import verify
from sensor.capture_folder import read_capture
from tests.clusters import ROOT, two_workers
from tests.conftest import Run

SPEC = """
format = "camtruth-dataset/1"
name = "small"
seed = 4
cameras = ["i400", "icx098"]
bodies = 3
test_bodies = 1
lamps = ["incandescent", "fluorescent"]
levels = [0.5, 1.0]
exposures_s = [0.01]
focus_distances_m = [0.18, 0.3]
effects = [[], ["row_noise.sigma_e=12"]]
frames = 2
renderer = "closed-form"
size = [96, 72]
"""


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("spec") / "spec.toml"
    path.write_text(SPEC)
    return path


@pytest.fixture(scope="module")
def whole(spec: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The dataset of an undisturbed run of one thread."""
    out = tmp_path_factory.mktemp("whole") / "set"
    make(out, plan(read_spec(spec)), threads=1)
    return out


def sums(folder: Path) -> bytes:
    return (folder / CHECKSUMS).read_bytes()


def test_every_combination_is_there_once(whole: Path) -> None:
    with (whole / "shards.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    lit = [row for row in rows if row["lamp"] != "none"]
    keys = ("camera", "body_seed", "effects", "focus_distance_m", "lamp", "level", "exposure_s")
    told = [tuple(row[key] for key in keys) for row in lit]
    assert len(told) == len(set(told)) == 2 * 3 * 2 * 2 * 2 * 2
    for row in rows:
        assert np.load(whole / row["file"], mmap_mode="r").shape == (2, 72, 96, 3)
        assert (whole / row["truth"]).exists()
        assert row["light"] == "" or (whole / row["light"]).exists()
    assert verify(whole).files == len(sums(whole).splitlines())


def test_train_and_test_share_no_camera_body(whole: Path) -> None:
    with (whole / "shards.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    bodies = {
        split: {(row["camera"], row["body_seed"]) for row in rows if row["split"] == split}
        for split in ("train", "test")
    }
    assert (len(bodies["train"]), len(bodies["test"])) == (4, 2)
    assert not bodies["train"] & bodies["test"]
    assert {camera for camera, _ in bodies["test"]} == {"i400", "icx098"}


def test_a_shard_is_a_capture_with_its_truth(whole: Path) -> None:
    folder = whole / "train" / sorted(p.name for p in (whole / "train").iterdir())[1]
    capture = read_capture(folder)
    assert [frames.count for frames in capture.frames] == [2] * 5
    assert capture.panels
    names = [entry["name"] for entry in json.loads((folder / "truth.json").read_text())["effects"]]
    assert ("row_noise" in names) == folder.name.endswith("e1")
    verify(folder)


def test_all_cores_give_the_same_bytes(spec: Path, whole: Path, tmp_path: Path) -> None:
    make(tmp_path / "set", plan(read_spec(spec)), threads=3)
    assert sums(tmp_path / "set") == sums(whole)


def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(
    spec: Path, whole: Path, tmp_path: Path
) -> None:
    planned = plan(read_spec(spec))
    with two_workers(tmp_path) as cluster:

        def kill_in_the_middle(frames: int) -> None:
            done = len(list(unfinished(tmp_path / "set").glob("t*/*/truth.json")))
            if done > len(planned.shards) // 3 and cluster.workers[0].poll() is None:
                cluster.workers[0].kill()
                cluster.workers[0].wait()

        make(
            tmp_path / "set",
            planned,
            scheduler=cluster.address,
            progress=kill_in_the_middle,
        )
        assert cluster.workers[0].poll() is not None
        assert cluster.workers[1].poll() is None
    assert sums(tmp_path / "set") == sums(whole)


def begun(spec: Path, out: Path, *words: str) -> subprocess.Popen[bytes]:
    program = "import sys; from camtruth.command import main; sys.exit(main())"
    line = ("dataset", "make", str(spec), "--out", str(out), *words)
    return subprocess.Popen(
        [sys.executable, "-c", program, *line],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.mark.parametrize("shards", [0, 9])
def test_killed_and_resumed_it_ends_with_the_same_bytes(
    shards: int, spec: Path, whole: Path, tmp_path: Path, run: Run
) -> None:
    out = tmp_path / "set"
    process = begun(spec, out)
    until = time.monotonic() + 60
    while (
        len(list(unfinished(out).glob("t*/*/truth.json"))) < shards or not unfinished(out).exists()
    ):
        assert time.monotonic() < until
        assert process.poll() is None
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not out.exists()
    stood = len(list(unfinished(out).glob("t*/[!.]*")))
    assert "--resume" in run("dataset", "make", spec, "--out", out).complaint
    answer = run("dataset", "make", spec, "--out", out, "--resume", "--json")
    assert json.loads(answer.out)["kept"] == stood
    assert sums(out) == sums(whole)
    verify(out)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["set"]


def test_an_unfinished_run_of_another_question_is_not_continued(
    spec: Path, tmp_path: Path, run: Run
) -> None:
    out = tmp_path / "set"
    process = begun(spec, out)
    until = time.monotonic() + 60
    while not (unfinished(out) / "light").exists():
        assert time.monotonic() < until
        time.sleep(0.005)
    other = tmp_path / "other.toml"
    other.write_text(SPEC.replace("seed = 4", "seed = 5"))
    assert "another run" in run("dataset", "make", spec, "--out", out, "--resume").complaint
    process.kill()
    process.wait()
    assert "another question" in run("dataset", "make", other, "--out", out, "--resume").complaint
    assert (unfinished(out) / LOCK).exists()
    assert run("dataset", "make", other, "--out", out, "--overwrite").code == 0
    assert "not empty" in run("dataset", "make", other, "--out", out).complaint


REFUSED = {
    "unknown key": ('name = "small"', 'nam = "small"', "unknown key 'nam'"),
    "no lamp": ('lamps = ["incandescent", "fluorescent"]', "lamps = []", "lamps"),
    "unknown lamp": ('"fluorescent"', '"fluorescant"', "did you mean 'fluorescent'"),
    "unknown camera": ('"i400"', '"i40"', "did you mean 'i400'"),
    "unknown effect": ("row_noise.sigma_e=12", "row_nose.sigma_e=12", "row_nose"),
    "a level twice": ("levels = [0.5, 1.0]", "levels = [1.0, 1.0]", "holds 1.0 twice"),
    "more test bodies": ("test_bodies = 1", "test_bodies = 4", "test_bodies = 4 of 3"),
    "no focus": ("[0.18, 0.3]", "[0.0001]", "focus"),
    "nonsense": ("seed = 4", "seed = four", "not TOML"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals(case: str, run: Run, tmp_path: Path) -> None:
    old, new, told = REFUSED[case]
    assert old in SPEC
    path = tmp_path / "spec.toml"
    path.write_text(SPEC.replace(old, new))
    assert told in run("dataset", "make", path).complaint
    assert not (tmp_path / "camtruth-out").exists()


def test_a_scheduler_that_is_not_there(
    spec: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("foundation.jobs.CONNECT_S", 0.5)
    words = ("dataset", "make", spec, "--scheduler", "tcp://127.0.0.1:9", "--out", "set")
    assert "no answer from the scheduler" in run(*words).complaint
