"""What each effect of the catalogue costs: a base frame with it against one without, in turns.

An effect may add as much time as the whole base camera takes, codecs excepted: they run frame by
frame in their own libraries. Times are those of the processors; what is below a hundredth of a base
frame is put down as that.
"""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.camera import frames_of, in_turns
from foundation.backend import backend
from sensor.camera_file import load
from sensor.catalogue import catalogue

FRAMES = {"cuda": 64, "llvm": 64, "scalar": 2}
"""Two batches with a JIT backend, so that frames that run in count as they do in a shot of 100."""
CODECS = ("jpeg", "demosaic_other")


def ratios() -> Iterator[tuple[str, float, float | None]]:
    frames = FRAMES[backend().name]
    base = load("icx098")
    for name, kind in catalogue().items():
        if base.get(kind) is not None:
            continue
        camera = base.plus(kind())
        turns = in_turns(
            {
                "without": (frames, lambda: frames_of(base, frames)),
                "with": (frames, lambda camera=camera: frames_of(camera, frames)),
            }
        )
        without = turns["without"].cpu
        added = max(turns["with"].cpu - without, without / 100)
        what = f"a base frame's time over what {name} adds: {added:.2f} ms to {without:.2f} ms"
        yield what, without / added, None if name in CODECS else 1.0
