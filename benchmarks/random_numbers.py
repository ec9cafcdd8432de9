"""Ways to draw two normal numbers for every pixel: why the stream is as it is. See docs/speed.md.

Each way makes the numbers of 32 frames of 640 x 480 and adds them up, so that nothing is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import drjit as dr

from benchmarks.camera import in_turns
from foundation.backend import backend
from sensor.box_muller import normals
from sensor.philox import Words, words

FRAMES, PIXELS = 32, 640 * 480

_ROTATIONS = ((10, 26), (11, 21), (13, 27), (23, 5), (6, 20), (17, 11), (25, 10), (18, 20))
"""Of Threefry 4x32; Salmon et al., SC 2011, table 4."""


def ratios() -> Iterator[tuple[str, float, float | None]]:
    if not backend().jit:
        return
    ways: dict[str, Callable[[Any, Any, Any], Any]] = {
        "ours": lambda *address: normals(words(*address)),
        "Dr.Jit's normal numbers": lambda *at: (
            backend().arrays.Philox4x32(*at).next_float32x4_normal()
        ),
        "Dr.Jit's words alone": lambda *at: _added(
            backend().arrays.Philox4x32(*at).next_uint32x4()
        ),
        "our words alone": lambda *address: _added(words(*address)),
        "words of Threefry 4x32 with 12 rounds alone": lambda *address: _added(threefry(*address)),
    }
    best = in_turns({name: (FRAMES, lambda way=way: draw(way)) for name, way in ways.items()})
    ours = best.pop("ours").cpu
    yield f"two normal numbers a pixel: {ours:.2f} ms of processors a frame", 1.0, None
    for name, turn in best.items():
        yield f"its time: {name}, {turn.cpu:.2f} ms", turn.cpu / ours, None


def draw(way: Callable[[Any, Any, Any], Any]) -> None:
    """Two draws for every pixel."""
    arrays = backend().arrays
    total: Any = 0.0
    for use in range(2):
        lane = dr.arange(arrays.UInt32, FRAMES * PIXELS // 4)
        frame = lane // (PIXELS // 4)
        key = dr.opaque(arrays.UInt64, 0x9E3779B97F4A7C15 + use)
        total = sum(way(key, lane - frame * (PIXELS // 4), frame), start=total)
    dr.eval(total)
    dr.sync_thread()


def _added(four: Any) -> list[Any]:
    return [backend().arrays.Float(four[0] ^ four[1] ^ four[2] ^ four[3])]


def threefry(key: Any, lane: Any, frame: Any) -> Words:
    """Four words by additions, turns and exclusive ors alone."""
    kind: Any = type(lane)
    keys = [kind(key), kind(key >> 32), kind(0), kind(0)]
    keys.append(keys[0] ^ keys[1] ^ kind(0x1BD11BDA))
    x = [lane + keys[0], frame + keys[1], kind(0), kind(0)]
    for turn in range(12):
        for left, by in zip((0, 2), _ROTATIONS[turn % 8], strict=True):
            right = (left + 1 if turn % 2 == 0 else 3 - left) % 4
            x[left] = x[left] + x[right]
            x[right] = ((x[right] << by) | (x[right] >> (32 - by))) ^ x[left]
        if turn % 4 == 3:
            step = turn // 4 + 1
            x = [x[k] + keys[(step + k) % 5] for k in range(4)]
            x[3] = x[3] + step
    return x[0], x[1], x[2], x[3]
