"""Which backend is chosen, and that a dangerous LLVM is never loaded."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from foundation import backend as backends
from foundation.backend import CHOICE_VARIABLE, LIBRARY_VARIABLE, llvm_version

ROOT = Path(__file__).parents[1]

VERSIONS = {
    "/usr/lib/x86_64-linux-gnu/libLLVM-14.so.1": 14,
    "/usr/lib/x86_64-linux-gnu/libLLVM-15.so": 15,
    "/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1": 19,
    "/usr/lib/x86_64-linux-gnu/libLLVM-19.so.1": 19,
    "/usr/lib/llvm-16/lib/libLLVM-16.0.6.so": 16,
    "/opt/homebrew/opt/llvm/lib/libLLVM.20.dylib": 20,
    "/usr/lib/libLLVM.so": None,
}


@pytest.mark.parametrize("path", VERSIONS)
def test_version_in_the_name(path: str) -> None:
    assert llvm_version(path) == VERSIONS[path]


def doctor(**variables: str) -> dict[str, object]:
    """What `camtruth doctor --json` says in a process with these environment variables."""
    clean = {k: v for k, v in os.environ.items() if k not in (CHOICE_VARIABLE, LIBRARY_VARIABLE)}
    program = "import sys; from camtruth.command import main; sys.exit(main())"
    result = subprocess.run(
        [sys.executable, "-c", program, "doctor", "--json"],
        env={**clean, **variables},
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    answer: dict[str, object] = json.loads(result.stdout)
    return answer


@pytest.mark.parametrize("name", ["libLLVM-14.so.1", "libLLVM-15.so", "libLLVM.so.15.0"])
def test_an_old_llvm_is_refused_by_its_name(name: str, tmp_path: Path) -> None:
    """It would load, and then take the whole process down: so it is not even opened."""
    library = tmp_path / name
    library.write_bytes(b"not a library: opening it would fail")
    answer = doctor(**{LIBRARY_VARIABLE: str(library)})
    assert answer["used"] in ("scalar", "cuda")
    entries = answer["backends"]
    assert isinstance(entries, list)
    (llvm,) = [entry for entry in entries if entry["name"] == "llvm"]
    assert not llvm["works"]
    assert "older than 16" in llvm["found"]
    assert "libllvm19" in llvm["remedy"]
    assert "\n" not in llvm["remedy"]


def test_a_library_that_runs_nothing_is_not_used(tmp_path: Path) -> None:
    library = tmp_path / "libLLVM-19.so.1"
    library.write_bytes(b"not a library")
    answer = doctor(**{LIBRARY_VARIABLE: str(library), "XDG_CACHE_HOME": str(tmp_path)})
    assert answer["used"] in ("scalar", "cuda")


def test_the_users_choice_is_followed() -> None:
    assert doctor(**{CHOICE_VARIABLE: "scalar"})["used"] == "scalar"


def test_an_unknown_choice_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CHOICE_VARIABLE, "scaler")
    with pytest.raises(backends.InputError, match="did you mean 'scalar'"):
        backends.backend()


def test_a_choice_that_does_not_work_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = backends.Probe(name="llvm", works=False, found="none", remedy="install it")
    monkeypatch.setattr(backends, "probe", lambda name: broken)
    backends._load.cache_clear()
    try:
        with pytest.raises(backends.InputError, match="install it"):
            backends.backend("llvm")
    finally:
        backends._load.cache_clear()


def test_what_was_proved_is_remembered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The child process runs once for each library; a damaged memory is made anew."""
    calls = []

    def child(*_: object, **__: object) -> subprocess.CompletedProcess[bytes]:
        calls.append(1)
        return subprocess.CompletedProcess([], 0)

    library = tmp_path / "libLLVM-19.so.1"
    library.write_bytes(b"")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(backends.subprocess, "run", child)
    assert backends._kernel_runs("llvm", str(library))
    assert backends._kernel_runs("llvm", str(library))
    assert len(calls) == 1
    (memory,) = (tmp_path / "camtruth").iterdir()
    memory.write_text("{", encoding="utf-8")
    assert backends._kernel_runs("llvm", str(library))
    assert len(calls) == 2
