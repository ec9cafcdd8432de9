"""A set is drawn, sealed, answered and scored; a run that was stopped goes on; a split is fair."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from camtruth.blind import baselines, making
from camtruth.blind.answering import Solver, checked, diagnose, solve
from camtruth.blind.design import BRIGHT, FILLED, design
from camtruth.blind.errors import BlindError
from camtruth.blind.format import CASES, NOMINAL, TRUTH, beside, open_seal, read_set
from camtruth.blind.making import make
from camtruth.blind.ruler import Ruler, battery, make_ruler
from camtruth.blind.severity import NEAR, at_strength, dressed_own
from camtruth.blind.splitting import split
from camtruth.blind.unsure import Rates
from foundation.output import CHECKSUMS, sha256
from foundation.verification import verify
from render.closed_form import render
from render.rate import RateImage
from scenes.scene import load as load_scene
from sensor import camera_file, protocol
from sensor.camera import Camera
from sensor.camera_file import load
from sensor.capture_folder import read_capture
from sensor.catalogue import catalogue
from sensor.effects.blooming import Blooming
from sensor.effects.row_noise import RowNoise
from sensor.protocol import Protocol, Shot
from sensor.record import record
from tests.conftest import Run, Small
from tests.killing import begun, kill_once

WIDTH, HEIGHT, FRAMES = 64, 48, 4
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


def light() -> dict[str, RateImage]:
    scene = load_scene("chart").with_size(WIDTH, HEIGHT)
    return {"incandescent": render(scene, "incandescent")}


def bases() -> dict[str, Camera]:
    return {"icx098": camera_file.load("icx098").resized(HEIGHT, WIDTH)}


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


@pytest.mark.parametrize("brightest_e", [13_500.0, 9_000.0, 2_000.0])
def test_what_begins_at_a_threshold_gets_the_severity_that_was_wanted(brightest_e: float) -> None:
    """Above the brightest pixel a full well does nothing, and soon below it everything: the
    strength between is found, and not the end of the range."""

    def probe(camera: Camera) -> tuple[float, float]:
        held = camera.get(Blooming)
        assert isinstance(held, Blooming)
        return max(0.0, (brightest_e - held.full_well_e) / 100.0), 0.0

    found = dressed_own(load("icx098"), Blooming(), 6.0, probe)
    assert 6.0 / NEAR < found.severity < 6.0 * NEAR
    full_well_e = found.parameters["full_well_e"]
    assert isinstance(full_well_e, float)
    assert brightest_e - full_well_e < 100.0 * 6.0 * NEAR


def test_severity_is_the_power_of_a_linear_test() -> None:
    """With unit noise, nothing known and signature s, z is |s| and severity |s| / 5: over 4000
    nulls its scatter is known to 1.1 %, and five of those are allowed."""
    rng = np.random.default_rng(3)
    s = np.array([3.0, 4.0, 0.0])
    ruler = Ruler(sd=np.ones(3), known=np.zeros((0, 3)), nulls=rng.normal(size=(4000, 3)))
    assert ruler.severity(s, s) == pytest.approx(1.0, rel=5 / np.sqrt(2 * 4000))
    taken = Ruler(sd=np.ones(3), known=np.eye(3)[:1], nulls=ruler.nulls)
    assert taken.absorbed(s) == pytest.approx(9 / 25)
    assert taken.severity(np.array([1.0, 0, 0]), np.array([2.0, 0, 0])) == 0.0


def test_what_nobody_knows_of_a_scene_is_no_severity() -> None:
    """A panel that reflects more, a lamp that shades otherwise, a picture that lies elsewhere: the
    ruler takes nearly all of each for calibration, and leaves much of row noise."""
    camera = bases()["icx098"]
    rates = {name: image.rate_e_per_s for name, image in light().items()}
    shots = (
        Shot(label="dark", exposure_s=0.02, frames=8),
        Shot(label="dim", light=("incandescent",), level=(0.4,), exposure_s=0.02, frames=8),
        Shot(label="bright", light=("incandescent",), level=(1.0,), exposure_s=0.02, frames=8),
    )
    asked = Protocol(name="short", shot=shots)
    ruler = make_ruler(camera, asked, rates, 50, nulls=4)

    def absorbed(other: Camera, others: Rates) -> float:
        one, two = (
            battery(record(body.with_body(9), asked, seen, seed=9))
            for body, seen in ((camera, rates), (other, others))
        )
        return ruler.absorbed(two - one)

    panel = np.ones((HEIGHT, WIDTH, 1), dtype=np.float32)
    panel[12:24, 22:32] = 1.03
    shading = np.linspace(0.97, 1.03, WIDTH, dtype=np.float32)[:, None]
    elsewhere = {
        name: ndimage.shift(rate, (0.0, 0.3, 0.0), order=1, mode="nearest")
        for name, rate in rates.items()
    }
    for other in (panel, shading):
        assert absorbed(camera, {name: rate * other for name, rate in rates.items()}) > 0.8
    assert absorbed(camera, elsewhere) > 0.8
    assert absorbed(camera.plus(RowNoise(sigma_e=40.0)), rates) < 0.7


def test_a_pattern_of_the_body_has_the_severity_of_its_size() -> None:
    """Of n figures the squares of nulls scatter by sqrt(2 n): a pattern of square 5 sqrt(2 n) is at
    its limit, wherever it is. Over 4000 nulls that scatter is known to 1.1 %."""
    rng = np.random.default_rng(4)
    n = 100
    ruler = Ruler(sd=np.ones(n), known=np.zeros((0, n)), nulls=rng.normal(size=(4000, n)))
    s = np.zeros(n)
    s[0] = np.sqrt(5 * np.sqrt(2 * n))
    assert ruler.severity(s, np.roll(s, 7)) == pytest.approx(1.0, rel=5 / np.sqrt(2 * 4000))


@pytest.mark.parametrize(
    "kind", [k for k in catalogue().values() if not k.base], ids=lambda k: k.name
)
def test_every_effect_can_be_made_weaker_and_stronger(kind: type) -> None:
    effect = kind()
    assert at_strength(effect, 1.0) == effect
    for factor in (1e-4, 0.3, 3.0, 1e4):
        scaled = at_strength(effect, factor)
        assert type(scaled) is kind  # its ranges were checked when it was made


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
