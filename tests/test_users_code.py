"""What people's code says stays off standard output, and unheard where it fails."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from foundation.errors import InputError
from foundation.users_code import effects_of_users, users_code
from tests.conftest import Run

SAYS = """import sys, warnings
import numpy as np
print("loading")
def mine(capture):
    print("measuring")
    sys.stdout.buffer.write(b"bytes")
    warnings.warn("warned")
    {}
    from camtruth import NoiseParameters
    return NoiseParameters(method="mine", channels={{}})
"""

pytestmark = pytest.mark.filterwarnings("ignore")


def test_json_stands_alone(run: Run, small_capture: Path, tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(SAYS.format("pass"), encoding="utf-8")
    answer = run("measure", small_capture, "--method", f"{file}:mine", "--json")
    assert json.loads(answer.out)["method"] == "mine"
    for word in ("loading", "measuring", "bytes"):
        assert word in answer.err


@pytest.mark.parametrize(
    "end", ["sys.exit(0)", "raise ValueError", "return 3", "np.log(-1) / 0 + x"]
)
def test_a_refusal_is_one_line(end: str, run: Run, small_capture: Path, tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(SAYS.replace('print("loading")\n', "").format(end), encoding="utf-8")
    if end == "return 3":
        file.write_text("def mine(capture):\n    return 3\n", encoding="utf-8")
    assert str(file) in run("measure", small_capture, "--method", f"{file}:mine").complaint


def test_an_effects_file_that_leaves(
    run: Run, small_capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line, and nothing beside the file: no bytecode either, where Python writes it."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    file = tmp_path / "effects.py"
    file.write_text("import sys\nprint('a')\nsys.exit()\n", encoding="utf-8")
    line = run("diagnose", small_capture, "--effects", file).complaint
    assert f"{file} calls sys.exit()" in line
    assert list(tmp_path.iterdir()) == [file]


def test_warnings_are_unheard_too(small_capture: Path, tmp_path: Path) -> None:
    """In a process of its own, as tests have ears for warnings."""
    file = tmp_path / "mine.py"
    file.write_text(SAYS.replace('print("loading")\n', "").format("1 / 0"), encoding="utf-8")
    program = "import sys; from camtruth.command import main; sys.exit(main())"
    words = ["measure", str(small_capture), "--method", f"{file}:mine"]
    made = subprocess.run(
        [sys.executable, "-c", program, *words],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
    )
    assert (made.returncode, made.stdout) == (2, "")
    assert re.fullmatch(r"camtruth: error: [^\n]*\n", made.stderr), made.stderr


def test_blocks_at_once_leave_the_streams_as_they_were(capsys: pytest.CaptureFixture[str]) -> None:
    before = sys.stdout, sys.stderr
    begun, go_on = threading.Event(), threading.Event()

    def slow() -> None:
        with users_code("slow.py"):
            begun.set()
            go_on.wait(10)
            print("slow")

    def fast() -> None:
        with users_code("fast.py"):
            thread.start()
            begun.wait(10)
            print("unheard")
            raise SystemExit

    thread = threading.Thread(target=slow)
    with pytest.raises(InputError):
        fast()
    go_on.set()
    thread.join()
    assert (sys.stdout, sys.stderr) == before
    assert capsys.readouterr() == ("", "slow\n")


def test_an_effect_that_fails_is_the_files_fault_and_ours_are_ours(tmp_path: Path) -> None:
    file = tmp_path / "effects.py"
    file.write_text("def apply():\n    print('here')\n    return 1 / 0\n", encoding="utf-8")
    theirs: dict[str, Any] = {}
    exec(compile(file.read_text(encoding="utf-8"), str(file), "exec"), theirs)
    told = r"effects.py fails with ZeroDivisionError.* \(line 3\)"
    with pytest.raises(InputError, match=told), effects_of_users([file]):
        theirs["apply"]()
    for files in ([file], []):
        with pytest.raises(ZeroDivisionError), effects_of_users(files):
            _ = 1 / 0
