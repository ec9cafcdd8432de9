"""Looking at the pixels beside a pixel: shifts and small convolutions with mirrored borders.

Mirroring about the border sample keeps the colour phase of a mosaic.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np

if TYPE_CHECKING:
    from sensor.signal import Signal


def mirrored(index: Any, shift: int, length: int) -> Any:
    """Shift indices 0 .. length-1 and reflect those that leave about the first or last sample."""
    signed = dr.int32_array_t(type(index))
    moved = dr.abs(signed(index) + shift)
    return type(index)(length - 1 - dr.abs(length - 1 - moved))


class Neighbours:
    """Gathers from an evaluated copy of a signal, so that any number of shifts reads memory once.

    Works on (f, H, W) and on (f, H, W, 3), where each colour sees its own neighbours.
    """

    def __init__(self, signal: Signal) -> None:
        self.shape = signal.shape
        self.tensor = type(signal.value)
        self.flat = signal.value.array
        dr.eval(self.flat)
        frame, self.row, self.column = signal.coordinates()
        self.start = frame * (self.shape[1] * self.shape[2])

    def flat_at(self, dy: int, dx: int, colour: int = 0) -> Any:
        """Flat array of the values dy rows below and dx columns to the right, of one colour."""
        _, height, width = self.shape[:3]
        y = mirrored(self.row, dy, height) if dy else self.row
        x = mirrored(self.column, dx, width) if dx else self.column
        depth = self.shape[3] if len(self.shape) == 4 else 1
        return dr.gather(type(self.flat), self.flat, (self.start + y * width + x) * depth + colour)

    def weighted(self, weights: Mapping[tuple[int, int], float]) -> Any:
        """Sum of shifted copies, {(dy, dx): weight}, as a tensor of the signal's shape.

        The value at (y, x) is the sum of weight x value at (y + dy, x + dx).
        """
        planes = [
            sum(weight * self.flat_at(dy, dx, colour) for (dy, dx), weight in weights.items())
            for colour in range(self.shape[3] if len(self.shape) == 4 else 1)
        ]
        return self.tensor(interleaved(planes), self.shape)


def run_length(arrays: ModuleType, width: int) -> int:
    """How many neighbouring columns a lane has on a backend: see `Runs`."""
    if not dr.is_jit_v(arrays.TensorXf):
        return 1
    return next(length for length in (8, 4, 1) if width % length == 0)


def fetched(flat: Any, run: Any, length: int) -> list[Any]:
    """The numbers of runs of so many neighbours (1, 4 or 8), by their place in the run.

    Args:
        flat: where they are; evaluated.
        run: which runs: the first number of each, divided by the length.
    """
    if length == 1:
        return [dr.gather(type(flat), flat, run)]
    pack = importlib.import_module(type(flat).__module__).Array4f
    fours = length // 4
    return [n for k in range(fours) for n in dr.gather(pack, flat, run * fours + k)]


def fetched_anywhere(flat: Any, place: Any, count: int) -> list[Any]:
    """So many neighbouring numbers or a few more, from the whole four that a place lies in.

    Args:
        flat: where they are; evaluated.
        place: where the first number is; for 3 numbers, which are fetched one by one.
        count: 3, or 2 more than a number of fours; `moved_on` picks these.
    """
    singly = 3 if count == 3 else 1
    last = [dr.gather(type(flat), flat, place + k) for k in range(count - singly, count)]
    if count == 3:
        return last
    pack = importlib.import_module(type(flat).__module__).Array4f
    fours = [dr.gather(pack, flat, place // 4 + k) for k in range(count // 4 + 1)]
    return [*(n for four in fours for n in four), *last]


def moved_on(numbers: list[Any], place: Any) -> list[Any]:
    """Numbers of `fetched_anywhere` from the place on."""
    if len(numbers) == 3:
        return numbers
    *held, last = numbers
    for step in (2, 1):
        further = (place & step) != 0
        held = [dr.select(further, b, a) for a, b in zip(held, held[step:], strict=False)]
    return [*held, last]


class Places:
    """Runs of neighbouring columns in the rows of frames, one run a lane.

    Attributes:
        length: columns in a run.
        frame: frame of each run.
        row: row of each run.
        first: first column of each run.
    """

    def __init__(self, arrays: ModuleType, shape: tuple[int, ...], length: int) -> None:
        frames, height, width = shape[:3]
        self.length = length
        runs = width // length
        lane = dr.arange(dr.uint32_array_t(dr.array_t(arrays.TensorXf)), frames * height * runs)
        line = lane // runs
        self.first = (lane - line * runs) * length
        self.frame = line // height
        self.row = line - self.frame * height

    def odd_column(self, k: int) -> Any:
        """Whether column k of the runs is an odd one of the image."""
        return k % 2 == 1 if self.length > 1 else ((self.first + k % 2) & 1) == 1


class Runs:
    """Rows of a mosaic in runs of neighbouring columns, one run a lane.

    Reading four pixels at once costs hardly more than reading one, so that with a JIT backend a
    lane has eight columns or four where the width allows it; otherwise one.

    Attributes:
        length: columns in a run.
        places: where each run is.
    """

    def __init__(self, signal: Signal) -> None:
        _, self.height, self.width = signal.shape
        self.length = run_length(signal.backend.arrays, self.width)
        self.flat = signal.value.array
        dr.eval(self.flat)
        self.places = Places(signal.backend.arrays, signal.shape, self.length)

    def line(self, dy: int, beside: int = 1) -> list[Any]:
        """The row dy below: so many pixels left of the run, its own, and as many right of it."""
        if not dr.is_jit_v(self.flat):
            return self._shifted(dy, beside)
        first, row = self.places.first, self.places.row
        row = mirrored(row, dy, self.height) if dy else row
        start = (self.places.frame * self.height + row) * self.width
        left = [mirrored(first, -k, self.width) for k in range(beside, 0, -1)]
        last = first + (self.length - 1)
        right = [mirrored(last, k, self.width) for k in range(1, beside + 1)]
        before, after = (
            [dr.gather(type(self.flat), self.flat, start + x) for x in side]
            for side in (left, right)
        )
        if self.length == 1:
            own = [dr.gather(type(self.flat), self.flat, start + first) if dy else self.flat]
        else:
            own = fetched(self.flat, (start + first) // self.length, self.length)
        return [*before, *own, *after]

    def _shifted(self, dy: int, beside: int) -> list[Any]:
        """What `line` returns where nothing is compiled: whole pictures, moved, in a fifth of the
        time.
        """
        image = self.flat.numpy().reshape(-1, self.height, self.width)
        lines = np.pad(image, ((0, 0), (abs(dy), abs(dy)), (beside, beside)), mode="reflect")
        first = abs(dy) + dy
        rows = lines[:, first : first + self.height]
        steps = range(2 * beside + 1)
        return [type(self.flat)(rows[..., k : k + self.width].ravel()) for k in steps]


def interleaved(planes: list[Any]) -> Any:
    """Flat planes of equal length as one array, pixel by pixel."""
    if len(planes) == 1:
        return planes[0]
    flat = type(planes[0])
    if not dr.is_jit_v(flat):
        return flat(np.stack([np.asarray(plane) for plane in planes], axis=1).ravel())
    arrays = importlib.import_module(flat.__module__)
    pack = getattr(arrays, f"Array{len(planes)}f", arrays.ArrayXf)
    return dr.ravel(pack(*planes))
