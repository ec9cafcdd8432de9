"""Looking at other frames of the batch: lag, filters in time, frames that are shown again.

A batch is larger than any cache, so that every look at another frame would wait for memory. A
filter goes along the frames pixel by pixel instead and keeps the last few numbers at hand: each is
read once and written once.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np

from sensor.neighbours import fetched, interleaved, run_length
from sensor.planes import Planes
from sensor.signal import Signal


@dataclass(frozen=True, kw_only=True, eq=False)
class Film:
    """The frames of a batch in memory.

    Attributes:
        planes: how the frames were held.
        flats: the mosaic, or each of three colours, pixel by pixel: flat, f H W, evaluated.
    """

    planes: Planes
    flats: tuple[Any, ...]

    @classmethod
    def of(cls, signal: Signal) -> Film:
        """The frames of a signal."""
        planes = signal.planes
        if signal.coloured:
            flats = tuple(interleaved(list(parts)) for parts in planes.colours)
        else:
            flats = (signal.value.array,)
        dr.eval(flats)
        return cls(planes=planes, flats=flats)

    def filtered(self, weights: Sequence[float], step: int = 1) -> Any:
        """Numbers for a signal: the sum over d of weights[d] times the frame d step frames before.

        Frames before the batch are taken to be like its first ones; they only feed frames that the
        camera cuts off. The additions for a frame are the same in any batch.
        """
        one = _in_numpy if not dr.is_jit_v(self.flats[0]) else _in_a_loop
        made = [one(flat, self.planes.shape[0], weights, step) for flat in self.flats]
        if len(made) == 1:
            return self.planes.arrays.TensorXf(made[0], self.planes.shape)
        return self._numbers(made)

    def shown(self, source: Callable[[Any], Any]) -> Any:
        """Numbers for a signal: in place of each frame the one that `source` makes of its index."""
        return self._numbers(self.flats, source)

    def _numbers(self, flats: Sequence[Any], source: Callable[[Any], Any] = lambda k: k) -> Any:
        frames, height, width = self.planes.shape[:3]
        length = len(self.planes.colours[0])
        runs = height * width // length
        lane = dr.arange(dr.uint32_array_t(type(flats[0])), frames * runs)
        frame = lane // runs
        at = lane + (source(frame) - frame) * runs
        colours = tuple(tuple(fetched(flat, at, length)) for flat in flats)
        made = Planes(colours=colours, shape=self.planes.shape, arrays=self.planes.arrays)
        return made if length > 1 else made.tensor


def _in_a_loop(flat: Any, frames: int, weights: Sequence[float], step: int) -> Any:
    """The filter for frames on a JIT backend: a lane goes along every frame that is `step` on."""
    kind, index = type(flat), dr.uint32_array_t(type(flat))
    size = dr.width(flat) // frames
    arrays = importlib.import_module(kind.__module__)
    length = run_length(arrays, size)
    pack = {8: arrays.ArrayXf, 4: arrays.Array4f}.get(length)
    runs = size // length
    lane = dr.arange(index, runs * min(step, frames))
    phase = lane // runs
    here = lane - phase * runs
    out = dr.empty(kind, dr.width(flat))

    def go_on(frame: Any, *seen: Any) -> Any:
        return frame < frames

    def go(frame: Any, *seen: Any) -> tuple[Any, ...]:
        run = here + frame * runs
        numbers = [*fetched(flat, run, length), *seen]
        total = [weights[-1] * number for number in numbers[-length:]]
        for d in range(len(weights) - 2, -1, -1):
            at = numbers[d * length :]
            total = [dr.fma(kind(weights[d]), at[k], total[k]) for k in range(length)]
        dr.scatter(out, pack(*total) if pack else total[0], run)
        return (frame + step, *numbers[: len(seen)])

    first = fetched(flat, here + phase * runs, length)
    dr.while_loop((phase, *first * (len(weights) - 1)), go_on, go)
    dr.eval(out)
    return out


def _in_numpy(flat: Any, frames: int, weights: Sequence[float], step: int) -> Any:
    """The filter on the scalar backend."""
    values = np.asarray(flat).reshape(frames, -1)
    total = np.zeros_like(values)
    for d, weight in enumerate(weights):
        total += np.float32(weight) * values[np.maximum(np.arange(frames) - d * step, 0)]
    return type(flat)(total.ravel())
