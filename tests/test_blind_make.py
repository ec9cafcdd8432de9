"""A set is drawn, sealed, answered and scored; a run that was stopped goes on; a split is fair."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from camtruth.blind import baselines, making
from camtruth.blind.answering import Solver, checked, diagnose, solve
from camtruth.blind.design import BRIGHT, FILLED, design
from camtruth.blind.errors import BlindError
from camtruth.blind.format import CASES, NOMINAL, TRUTH, beside, open_seal, read_set
from camtruth.blind.making import make
from camtruth.blind.ruler import Ruler
from foundation.output import CHECKSUMS, sha256
from foundation.verification import verify
from sensor import camera_file
from sensor.capture_folder import read_capture
from sensor.catalogue import catalogue
from sensor.protocol import Protocol, Shot
from tests.blind_bench import HEIGHT, WIDTH, bases, light
from tests.conftest import Run
from tests.killing import begun, kill_once

FRAMES = 4
ASKED = {"null": 1, "own": 1, "left-out": 1, "put-back": 1, "strange": 1, "others": 1}
SOLVER = """
def fake(folder, without):
    assert not (folder / "truth.json").exists()
    return {
        "format": "camtruth-gap/1",
        "verdict": "unexplained" if without else "matched",
        "effects": [],
        "gap": {"shrink": 0.0, "at_floor": True},
        "where": [],
    }

def fails(folder, without):
    raise RuntimeError("no")
"""


SHOTS = Protocol(
    name="two",
    shot=(
        Shot(label="dark", exposure_s=0.03, frames=FRAMES),
        Shot(label="lit", light=("incandescent",), exposure_s=0.03, frames=FRAMES),
    ),
)


def made_at(out: Path, seed: int = 5, **more: object) -> None:
    make(
        out,
        "small",
        asked=ASKED,
        bases=bases(),
        protocol=SHOTS,
        images=light(),
        scene="chart",
        seed=seed,
        nulls=3,
        threads=1,
        **more,  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("blind") / "small"
    made_at(out)
    return out


def test_every_case_is_a_capture_without_its_truth(small_set: Path) -> None:
    document = read_set(small_set)
    assert len(document.case) == sum(ASKED.values())
    verify(small_set)
    for case in document.case:
        folder = small_set / CASES / case.name
        capture = read_capture(folder)
        assert (capture.camera, capture.frames[0].dn.shape[:3]) == (
            "withheld",
            (FRAMES, HEIGHT, WIDTH),
        )
        assert camera_file.load(str(folder / NOMINAL)).width == WIDTH
    assert not list(small_set.rglob(TRUTH))


def test_the_truth_is_the_one_committed_to(small_set: Path) -> None:
    document = read_set(small_set)
    truth = open_seal(beside(small_set, "seal"), document.commitment)
    assert Counter(case.group for case in truth.cases.values()) == ASKED
    told = {case.name: case.without for case in document.case}
    for name, case in truth.cases.items():
        assert told[name] == case.without
        assert len(case.effects) == (case.group != "null")
        assert (case.group == "left-out") == bool(case.without)
    back = next(case for case in truth.cases.values() if case.group == "put-back")
    assert back.twin is not None
    left = truth.cases[back.twin]
    assert [e.parameters for e in left.effects] == [e.parameters for e in back.effects]
    assert left.seed != back.seed


def test_nothing_of_the_secret_is_in_the_set(small_set: Path) -> None:
    truth = json.loads((beside(small_set, "seal") / TRUTH).read_text())
    for file in small_set.rglob("*"):
        if file.is_file():
            content = file.read_bytes()
            for word in (truth["salt"], truth["secret"]):
                assert word.encode() not in content
                assert bytes.fromhex(word) not in content


def test_the_seed_alone_does_not_make_the_set_again() -> None:
    one, two = (design(ASKED, bases(), 5, secret) for secret in (b"a" * 32, b"b" * 32))
    assert one == design(ASKED, bases(), 5, b"a" * 32)
    assert {case.name for case in one}.isdisjoint(case.name for case in two)
    assert {case.draw for case in one}.isdisjoint(case.draw for case in two)


def test_a_set_is_answered_and_scored(small_set: Path, tmp_path: Path, run: Run) -> None:
    solver = tmp_path / "solver.py"
    solver.write_text(SOLVER)
    out = tmp_path / "answers"
    told = run("blind", "solve", small_set, "--solver", f"{solver}:fake", "--out", out)
    assert told.code == 0, told.err
    assert sha256(out / CHECKSUMS) in told.out
    words = ("blind", "score", small_set, "--answers", out, "--out", tmp_path / "score", "--json")
    told = run(*words)
    assert told.code == 0, told.err
    document = json.loads(told.out)
    alarms = next(r for r in document["rows"]["answers"] if r["group"] == "nothing wrong")
    assert (alarms["hits"], alarms["cases"]) == (0, 1)
    marks = {m["group"]: m for m in document["marks"]["answers"]}
    assert marks["left-out"]["unexplained"]


def test_a_run_that_was_stopped_goes_on(small_set: Path, tmp_path: Path) -> None:
    solver = tmp_path / "solver.py"
    solver.write_text(SOLVER.replace('raise RuntimeError("no")', STOPS))
    out = tmp_path / "answers"
    with pytest.raises(Exception, match="stopped"):
        solve(small_set, out, solver=f"{solver}:fails", threads=1)
    kept = {
        p.name: p.stat().st_mtime_ns for p in out.with_name("answers.unfinished").glob("*.json")
    }
    assert 0 < len(kept) < sum(ASKED.values())
    solve(small_set, out, solver=f"{solver}:fails", threads=1, resume=True)
    for name, when in kept.items():
        assert (out / name).stat().st_mtime_ns == when
    verify(out)


def test_an_examination_that_is_killed_goes_on(small_set: Path, tmp_path: Path, run: Run) -> None:
    """By `kill -9` between two answers; what stands is not asked again, the bytes are the same."""
    solver = tmp_path / "solver.py"
    solver.write_text(SLOW + SOLVER.replace("    assert", "    one_by_one()\n    assert"))
    words = ("blind", "solve", str(small_set), "--solver", f"{solver}:fake")
    assert run(*words, "--out", tmp_path / "whole").code == 0
    out, work = tmp_path / "answers", tmp_path / "answers.unfinished"
    kill_once(begun(words, out), 1, lambda: len(list(work.glob("[!.]*.json"))))
    kept = {p.name: p.stat().st_mtime_ns for p in work.glob("[!.]*.json")}
    assert 0 < len(kept) < sum(ASKED.values())
    assert "--resume" in run(*words, "--out", out).complaint
    assert run(*words, "--out", out, "--resume").code == 0
    for name, when in kept.items():
        assert (out / name).stat().st_mtime_ns == when
    assert (out / CHECKSUMS).read_bytes() == (tmp_path / "whole" / CHECKSUMS).read_bytes()
    verify(out)


SLOW = """
import threading, time
turn = threading.Lock()
def one_by_one():
    with turn:
        time.sleep(0.3)
"""

STOPS = """
    mark = __import__("pathlib").Path(__file__).with_name("calls")
    calls = int(mark.read_text()) if mark.exists() else 0
    mark.write_text(str(calls + 1))
    if calls == 2:
        raise RuntimeError("stopped")
    return fake(folder, without)"""


def test_making_goes_on_with_the_same_secret(
    small_set: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The run is stopped after the first case; the next one keeps that case and its truth."""
    out, real, calls = tmp_path / "set", making.make_case, []

    def stops(place: making.Place, wanted: making.Wanted) -> dict[str, object]:
        calls.append(wanted.name)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return real(place, wanted)

    monkeypatch.setattr(making, "make_case", stops)
    monkeypatch.setattr(making, "make_ruler", lambda *a, **k: FLAT)
    monkeypatch.setattr(making, "dressed", lambda place, wanted, plain: (plain, ()))
    with pytest.raises(KeyboardInterrupt):
        made_at(out)
    made_at(out, resume=True)
    assert calls.count(calls[0]) == 1
    assert calls.count(calls[1]) == 2
    assert calls[0] in {case.name for case in read_set(out).case}


FLAT = Ruler(sd=np.ones(1), known=np.zeros((0, 1)), nulls=np.ones((2, 1)))


@pytest.mark.parametrize("wrong", ["", "{}", '{"format": "camtruth-gap/1", "verdict": "perhaps"}'])
def test_an_answer_that_is_none_is_refused(
    wrong: str, small_set: Path, tmp_path: Path, run: Run
) -> None:
    solver = tmp_path / "solver.py"
    solver.write_text(f"import json\ndef say(folder, without):\n    return json.loads({wrong!r})\n")
    words = ("--solver", f"{solver}:say", "--out", tmp_path / "answers")
    assert "expected" in run("blind", "solve", small_set, *words).complaint


def test_the_brightest_shot_nearly_fills_the_camera(small_set: Path) -> None:
    """Light varies by 5 %, gain cancels, and black adds up to 5 DN: within 25 %, five of those."""
    for case in read_set(small_set).case:
        lit = read_capture(small_set / CASES / case.name).lit[0]
        assert np.quantile(lit.dn, BRIGHT) == pytest.approx(FILLED * 255, rel=0.25)


def test_a_capture_that_is_refused_is_answered_with_the_reason(
    small_set: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuses(*words: object, **more: object) -> None:
        raise BlindError("this", "expected that", "do so")

    monkeypatch.setattr("camtruth.diagnosing.diagnosis", refuses)
    found = checked(diagnose(small_set / CASES / read_set(small_set).case[0].name, ()), "it")
    assert found["verdict"] == "insufficient data"
    assert "expected that" in found["notes"][0]


@pytest.mark.parametrize("solver", [baselines.histogram, baselines.refit_free])
def test_a_baseline_answers_with_what_it_may_suspect(
    solver: Solver, small_set: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = {name: catalogue()[name] for name in ("row_noise", "column_fpn", "gamma")}
    monkeypatch.setattr(baselines, "catalogue", lambda: few)
    folder = small_set / CASES / read_set(small_set).case[0].name
    found = checked(solver(folder, ("gamma",)), "it")
    assert {c["name"] for c in found["candidates"]} == {"row_noise", "column_fpn"}
    assert sum(c["probability"] for c in found["candidates"]) == pytest.approx(1.0)
    json.dumps(found, allow_nan=False)
