"""The diagnosis of a capture: against what is promised of it, and how its time grows.

Promised are 60 s and 3 GB for 9 shots of 40 frames at 640 x 480 on two cores with LLVM, and ten
times as long at most without. Each diagnosis is a process of its own. Growth is told by smaller
frames, each time with one thing halved, or nearly: a ratio of 0.5 is growth in proportion.
"""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from analysis.identifiability.known import small_light
from camtruth.diagnosing import suspects
from camtruth.simulating import capture_to
from foundation.backend import CHOICE_VARIABLE, backend
from render.rate import RateImage
from sensor.camera_file import load as load_camera
from sensor.effects.column_fpn import ColumnFpn
from sensor.protocol import Protocol
from sensor.protocol import load as load_protocol

PROMISED_S, PROMISED_MB = 60.0, 3000.0
SCALAR = 10.0
"""Times as long, without a JIT backend."""

SIZE, SMALL = (640, 480), (320, 240)
FRAMES = 40
SCENE = "chart"
PATTERN = ColumnFpn(sigma_e=12.0)

CHILD = """
import sys, time
from pathlib import Path
from camtruth.diagnosing import diagnosis
from foundation.backend import backend
backend()
started = time.perf_counter()
found = diagnosis(Path(sys.argv[1]), without=sys.argv[2:])
seconds = time.perf_counter() - started
status = Path("/proc/self/status")
peak = status.read_text().split("VmHWM:")[1].split()[0] if status.exists() else "nan"
print(seconds, float(peak) / 1024, len(found.report.effects))
"""


def ratios() -> Iterator[tuple[str, float, float | None]]:
    paper = with_frames(load_protocol("paper"), FRAMES)
    half = dataclasses.replace(paper, shot=paper.shot[::2])
    names = [kind.name for kind in suspects([], [])]
    others = [name for name in names if name != PATTERN.name][::2]
    with tempfile.TemporaryDirectory() as there:
        whole = taken(Path(there) / "whole", paper, small_light(SCENE, *SIZE))
        if backend().jit:
            seconds, mb = _child(whole)
            what = f"{len(paper.shot)} shots of {FRAMES} frames at {SIZE[0]} x {SIZE[1]}"
            yield f"of 60 s: {what}, {seconds:.1f} s", PROMISED_S / seconds, 1
            yield f"of 3 GB: the same, {mb:.0f} MB", PROMISED_MB / mb, 1
        light = small_light(SCENE, *SMALL)
        small = taken(Path(there) / "small", paper, light)
        first, _ = _child(small)
        yield f"at {SMALL[0]} x {SMALL[1]}: {first:.1f} s", 1.0, None
        fewer, _ = _child(small, others)
        each = (first - fewer) / len(others)
        what = f"{len(names) - len(others)} suspects of {len(names)}, {each:.2f} s each"
        yield f"of that time: {what}", fewer / first, None
        for what, protocol in (
            (f"{FRAMES // 2} frames of {FRAMES}", with_frames(paper, FRAMES // 2)),
            (f"{len(half.shot)} shots of {len(paper.shot)}", half),
        ):
            seconds, _ = _child(taken(Path(there) / what.replace(" ", "-"), protocol, light))
            yield f"of that time: {what}", seconds / first, None
        if backend().jit:
            slow, _ = _child(small, backend_name="scalar")
            what = f"of {SCALAR:g} times as long: without LLVM or CUDA, {slow:.0f} s"
            yield what, SCALAR * first / slow, 1


def with_frames(protocol: Protocol, frames: int) -> Protocol:
    """The same shots with so many frames each."""
    shots = tuple(dataclasses.replace(shot, frames=frames) for shot in protocol.shot)
    return dataclasses.replace(protocol, shot=shots)


def taken(folder: Path, protocol: Protocol, light: dict[str, RateImage]) -> Path:
    """A capture by a camera whose columns differ."""
    first = next(iter(light.values())).rate_e_per_s
    camera = load_camera("icx098").plus(PATTERN).resized(*first.shape[:2])
    folder.mkdir()
    capture_to(folder, camera, protocol, light, seed=1, scene=SCENE)
    return folder


def _child(
    folder: Path, without: Sequence[str] = (), backend_name: str | None = None
) -> tuple[float, float]:
    """Seconds and peak megabytes of a diagnosis that names the effect."""
    chosen = {CHOICE_VARIABLE: backend_name} if backend_name else {}
    run = subprocess.run(
        [sys.executable, "-c", CHILD, str(folder), *without],
        cwd=Path(__file__).parents[1],
        env={**os.environ, **chosen},
        capture_output=True,
        text=True,
        check=True,
    )
    seconds, mb, named = run.stdout.split()
    assert int(named) == 1, f"{named} effects named"
    return float(seconds), float(mb)
