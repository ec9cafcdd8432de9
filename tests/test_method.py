"""Estimators by name, and a user's own from a file."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from analysis import estimators
from analysis.errors import MethodError
from analysis.estimators.irie import irie
from analysis.methods import method, method_names
from analysis.parameters import NoiseParameters
from foundation.errors import InputError
from sensor.frames import Capture, Frames, Shot, TooFewFrames

USERS = '''
from __future__ import annotations
from dataclasses import dataclass
import numpy as np
from analysis.parameters import CannotTell, Estimate, NoiseParameters

@dataclass(frozen=True)
class Kept:
    value: float

def darkness(capture):
    """The mean dark level, as a first estimator."""
    kept = Kept(float(np.mean(capture.darks[0].dn)))
    found = Estimate(value=kept.value, se=0.1, unit="DN")
    return NoiseParameters(method="darkness", channels={"Y": {"fpn": found}})

def unsure(capture):
    return NoiseParameters(method="unsure", channels={"Y": {"fpn": CannotTell(reason="dark")}})

def fails(capture):
    return 1 / 0

def number(capture):
    return 3

def nan(capture):
    found = Estimate(value=float("nan"), se=0.1, unit="DN")
    return NoiseParameters(method="nan", channels={"Y": {"fpn": found}})

def one(key="fpn", channel="Y", *, value=1.0, se=0.1, unit="DN"):
    found = Estimate(value=value, se=se, unit=unit)
    return NoiseParameters(method="one", channels={channel: {key: found}})

def words(capture):
    return one(value="x")

def truth(capture):
    return one(se=True)

def negative(capture):
    return one(se=-0.1)

def electrons(capture):
    return one(unit="e-")

def red(capture):
    return one(channel="R")

def listed(capture):
    return NoiseParameters(method="listed", channels=[1])

def object_(capture):
    return NoiseParameters(method="object", channels={}, extra={"it": object()})

def narrow(capture):
    return one("more", value=np.float32(1.5), se=np.int64(1), unit="furlong")

def leaves(capture):
    raise SystemExit

def bare(capture):
    return NoiseParameters(method="bare", channels={"Y": {"fpn": 1.0}})

def none():
    return None

def two(capture, truth):
    return None

level = 3
'''


@pytest.fixture
def users(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(USERS)
    return path


def capture(frames: int = 3) -> Capture:
    dn = np.random.default_rng(0).integers(8, 13, (frames, 20, 20)).astype(np.uint8)
    shot = Shot(label="dark", exposure_s=0.01, frames=frames)
    return Capture(camera="test", frames=(Frames(dn=dn, shot=shot, pixels="mono8", bits=8),))


def test_a_file_with_a_function_of_its_own_name_is_a_method():
    assert "irie" in method_names()
    assert method("irie") is irie


def test_every_file_beside_the_estimators_is_one():
    """What they share is in a folder, where no file becomes a method by a function of its name."""
    folder = Path(estimators.__path__[0])
    assert method_names() == sorted(path.stem for path in folder.glob("[!_]*.py"))
    assert (folder / "parts" / "panel_noise.py").is_file()


def test_a_users_function_is_a_method(users):
    found = method(f"{users}:darkness")(capture())
    assert isinstance(found, NoiseParameters)
    assert found.channels["Y"]["fpn"].value == pytest.approx(capture().darks[0].dn.mean())
    assert method(f"{users}:unsure")(capture()).channels["Y"]["fpn"].reason == "dark"


def test_the_users_file_may_be_named_from_here(users, monkeypatch):
    monkeypatch.chdir(users.parent)
    with pytest.raises(MethodError, match=r"ZeroDivisionError: division by zero \(line 21\)"):
        method("mine.py:fails")(capture())
    assert method(os.path.join(".", "mine.py") + ":darkness")(capture()).method == "darkness"  # noqa: PTH118


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("iri", r"unknown method 'iri'; expected one of .*irie.*, or FILE.py:function; did you"),
        ("nothing.py:f", "no file 'nothing.py'"),
        ("{}:missing", "no function 'missing' in .*; expected one of bare, darkness, electrons"),
        ("{}:level", "'level' in .* is no function"),
        ("{}:none", "'none' in .* cannot be called with one argument"),
        ("{}:two", r"'two' in .* cannot be called with one argument.*def two\(capture\):"),
    ],
)
def test_what_is_no_method_is_told_at_once(users, name, said):
    with pytest.raises(MethodError, match=said):
        method(name.format(users))


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("fails", r"'fails' raised ZeroDivisionError"),
        ("number", "returned int; expected NoiseParameters"),
        ("nan", "returned nan .* for fpn of Y; expected finite figures"),
        ("words", r"mine.py returned 'x' \+- 0.1 for fpn of Y; expected two numbers"),
        ("truth", r"returned 1.0 \+- True for fpn of Y; expected two numbers"),
        ("negative", "a standard error of -0.1 for fpn of Y; expected none below 0"),
        ("electrons", "returned 'e-' as the unit for fpn of Y; expected 'DN'"),
        ("red", "mine.py returned a channel 'R'; expected Y as the capture has"),
        ("listed", "returned noise parameters that are no JSON"),
        ("object_", "returned noise parameters that are no JSON"),
        ("bare", "returned float for fpn of Y; expected an Estimate or CannotTell"),
    ],
)
def test_what_breaks_the_contract_is_told_when_it_does(users, name, said):
    with pytest.raises(MethodError, match=said):
        method(f"{users}:{name}")(capture())


def test_a_users_figures_become_plain_ones(users):
    found = method(f"{users}:narrow")(capture()).to_json()["channels"]["Y"]["more"]
    assert json.dumps(found) == '{"value": 1.5, "se": 1.0, "unit": "furlong"}'


def test_a_users_file_does_not_end_the_program(users, tmp_path):
    with pytest.raises(InputError, match=r"mine.py calls sys.exit\(\); expected code that returns"):
        method(f"{users}:leaves")(capture())
    path = tmp_path / "leaves.py"
    path.write_text("import sys\nsys.exit(3)\n")
    with pytest.raises(InputError, match=r"leaves.py calls sys.exit\(3\)"):
        method(f"{path}:f")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def f(:", r"SyntaxError: [^()]* \(line 1\);"),
        ("import no_such_module_here", "ModuleNotFoundError.*line 1"),
    ],
)
def test_a_file_that_does_not_load_is_told(tmp_path, text, said):
    path = tmp_path / "broken.py"
    path.write_text(text)
    with pytest.raises(MethodError, match=f"cannot be loaded, {said}"):
        method(f"{path}:f")


def test_errors_for_people_pass_through_a_users_estimator(tmp_path):
    path = tmp_path / "wraps.py"
    path.write_text("from analysis.estimators.irie import irie\ndef mine(c): return irie(c)\n")
    with pytest.raises(TooFewFrames):
        method(f"{path}:mine")(capture(frames=1))
