"""Commands in processes of their own, to be struck down while they write."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from tests.clusters import ROOT

Begun = subprocess.Popen[bytes]

PATIENCE_S = 120
PROGRAM = "import sys; from camtruth.command import main; sys.exit(main())"


def begun(words: tuple[str, ...], out: Path, least: Callable[[], None] | None = None) -> Begun:
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words, "--out", str(out)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=least,
    )


def standing(folder: Path) -> dict[Path, os.stat_result]:
    """The files below a folder in which another process writes.

    What it moves away between being listed and being looked at does not stand there.
    """
    found = {}
    for place, _, names in os.walk(folder):
        for name in names:
            with contextlib.suppress(FileNotFoundError):
                found[Path(place, name)] = Path(place, name).stat()
    return found


def kill_once(process: Begun, least: int, pieces: Callable[[], int]) -> None:
    """Let it write until so many pieces stand there, or it ends by itself; then strike."""
    until = time.monotonic() + PATIENCE_S
    while pieces() < least and process.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.communicate()
