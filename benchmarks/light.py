"""Seconds and memory until a rate image is quiet: 5e-4 inside every panel.

Thin lens and real lens, LLVM and scalar, 640 x 480 and 1280 x 960. Kernels are warm: each size is
rendered once before it is timed, as a study renders many. Figures depend on the machine, so only
two are promised: a thin lens in 3 s on two cores with LLVM, and a real lens within 8 times of it.
"""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time
from collections.abc import Iterator

from foundation.backend import CHOICE_VARIABLE, backend, probe
from render.path_traced import render
from scenes.lens import Lens
from scenes.scene import Scene, load

WANTED = 5e-4
FIRST = 8
"""Light paths per pixel to begin with: one in each batch."""
REAL = Lens(
    kind="real",
    prescription="speed-panchro",
    focal_length_mm=4.3,
    f_number=2.8,
    focus_distance_m=0.30,
    transmission=0.9,
)
SECONDS, TIMES, MEGABYTES = 3.0, 8.0, 1500.0
PEAK = """
import resource
from benchmarks.light import seconds, scene
seconds(scene(1280, 960, {real}))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def scene(width: int, height: int, real: bool) -> Scene:
    chart = load("chart").with_size(width, height)
    return dataclasses.replace(chart, lens=REAL) if real else chart


def seconds(where: Scene) -> tuple[float, int]:
    """Seconds and light paths per pixel until it is quiet."""
    started = time.perf_counter()
    image = render(where, "fluorescent", samples=FIRST, noise=WANTED)
    return time.perf_counter() - started, image.header.samples


def _warm(where: Scene) -> tuple[float, int]:
    seconds(where)
    return seconds(where)


def ratios() -> Iterator[tuple[str, float, float | None]]:
    name = backend().name
    thin, samples = _warm(scene(640, 480, False))
    promised = 1.0 if name == "llvm" else None
    what = f"{SECONDS:g} s against {thin:.2f} s: thin lens, 640 x 480, {samples} paths, {name}"
    yield what, SECONDS / thin, promised
    large, _ = _warm(scene(1280, 960, False))
    yield f"4 times the pixels against {large / thin:.2f} times the seconds", 4 * thin / large, None
    if backend().jit:
        real, samples = _warm(scene(640, 480, True))
        what = f"{TIMES:g} thin lenses against a real one in {real:.2f} s, {samples} paths, {name}"
        yield what, TIMES * thin / real, 1.0
        large, _ = _warm(scene(1280, 960, True))
        what = f"4 times the pixels against {large / real:.2f} times the seconds, real lens"
        yield what, 4 * real / large, None
    if name != "scalar" and probe("scalar").works:
        yield _against_scalar(thin, name)
    for real_lens in (False, True) if backend().jit else (False,):
        peak = subprocess.run(
            [sys.executable, "-c", PEAK.format(real=real_lens)],
            capture_output=True,
            text=True,
            check=True,
        )
        megabytes = float(peak.stdout.split()[-1])
        lens = "real" if real_lens else "thin"
        what = f"{MEGABYTES:g} MB against {megabytes:.0f} MB: {lens} lens, 1280 x 960"
        yield what, MEGABYTES / megabytes, 1.0


def _against_scalar(thin: float, name: str) -> tuple[str, float, None]:
    before = os.environ.get(CHOICE_VARIABLE)
    os.environ[CHOICE_VARIABLE] = "scalar"
    try:
        slow, _ = seconds(scene(640, 480, False))
    finally:
        if before is None:
            del os.environ[CHOICE_VARIABLE]
        else:
            os.environ[CHOICE_VARIABLE] = before
    return f"{name} in {thin:.2f} s against scalar in {slow:.2f} s, thin lens", slow / thin, None
