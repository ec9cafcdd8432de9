"""Time and memory for shots of 10 to 10,000 frames, each in a process of its own.

The frames are let go as they come: a disk would be timed instead. Without a JIT backend the longest
shots are left out; they take a quarter of an hour.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from foundation.backend import backend

COUNTS = {"cuda": (10, 100, 1000, 10_000), "llvm": (10, 100, 1000, 10_000), "scalar": (10, 100)}
FLAT = 0.5
"""Promised: the time of a frame in the shortest shot over that in a longer one, at least."""

CHILD = """
import sys, time
from pathlib import Path
from benchmarks.camera import frames_of
from sensor.camera_file import load
camera, frames = load("icx098"), int(sys.argv[1])
frames_of(camera, frames if frames < 32 else 32 + frames % 32)
started = time.perf_counter()
frames_of(camera, frames)
seconds = time.perf_counter() - started
status = Path("/proc/self/status")
peak = status.read_text().split("VmHWM:")[1].split()[0] if status.exists() else "nan"
print(1e3 * seconds / frames, float(peak) / 1024)
"""


def ratios() -> Iterator[tuple[str, float, float | None]]:
    measured = {count: _child(count) for count in COUNTS[backend().name]}
    (shortest, (first_ms, first_mb)), *others = measured.items()
    yield f"{shortest} frames: {first_ms:.2f} ms each, peak {first_mb:.0f} MB", 1.0, None
    for count, (ms, mb) in others:
        yield (
            f"the time of a frame of {shortest}, in a shot of {count}: {ms:.2f} ms",
            first_ms / ms,
            FLAT,
        )
        yield f"of the peak memory of the first {shortest}: {mb:.0f} MB", mb / first_mb, None


def _child(frames: int) -> tuple[float, float]:
    words = [sys.executable, "-c", CHILD, str(frames)]
    folder = Path(__file__).parents[1]
    run = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=True)
    ms, mb = map(float, run.stdout.split())
    return ms, mb
