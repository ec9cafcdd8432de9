"""Numbers by their place in a run: how an image is held until somebody needs its pixels.

Random numbers are drawn, and a demosaicer makes colours, for eight pixels of a row at a time.
Writing them in the order of the pixels costs half the time of making them, and whatever looks at
each number by itself does not need it; so they are put in order at the first look at the pixels.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.neighbours import fetched, interleaved, run_length
from sensor.whole_numbers import whole_number


@dataclass(frozen=True, kw_only=True, eq=False)
class Planes:
    """The mosaic of a batch of frames, or its red, green and blue values.

    Attributes:
        colours: for the mosaic, or for each colour, its values as 1 flat Dr.Jit array of f H W, or
            as 4 of a quarter of that, which hold every fourth column each, or as 8 of an eighth:
            as many as `sensor.neighbours.run_length` tells.
        shape: (f, H, W) or (f, H, W, 3).
        arrays: the Dr.Jit module they are of.
        run_in: how many frames more the arrays begin with, which are no part of it.
    """

    colours: tuple[tuple[Any, ...], ...]
    shape: tuple[int, ...]
    arrays: ModuleType
    run_in: int = 0

    @classmethod
    def of(cls, tensor: Any, arrays: ModuleType) -> Planes:
        """The planes of numbers that lie pixel by pixel: a tensor (f, H, W) or (f, H, W, 3)."""
        flat, shape = tensor.array, tuple(tensor.shape)
        dr.eval(flat)
        length = run_length(arrays, shape[2])
        depth = shape[3] if len(shape) == 4 else 1
        lane = dr.arange(dr.uint32_array_t(type(flat)), dr.width(flat) // (depth * length))
        numbers = [n for k in range(depth) for n in fetched(flat, depth * lane + k, length)]
        return cls(
            colours=tuple(tuple(numbers[c::depth]) for c in range(depth)),
            shape=shape,
            arrays=arrays,
        )

    def map(self, change: Callable[[Any], Any]) -> Planes:
        """The planes after a change that looks at each number by itself."""
        colours = tuple(tuple(change(part) for part in parts) for parts in self.colours)
        return dataclasses.replace(self, colours=colours)

    def without(self, run_in: int) -> Planes:
        """The planes less their first frames."""
        shape = (self.shape[0] - run_in, *self.shape[1:])
        return dataclasses.replace(self, shape=shape, run_in=self.run_in + run_in)

    @cached_property
    def tensor(self) -> Any:
        """The same numbers pixel by pixel: a tensor of their shape."""
        planes = [interleaved(list(parts)) for parts in self.colours]
        whole = (self.run_in + self.shape[0], *self.shape[1:])
        tensor = self.arrays.TensorXf(interleaved(planes), whole)
        return tensor[self.run_in :] if self.run_in else tensor

    def as_bytes(self) -> NDArray[np.uint8]:
        """Codes of 0 to 255 as bytes, pixel by pixel. For a JIT backend."""
        import cv2

        numbers = self.held
        if len(numbers) == 1:
            return np.asarray(numbers[0].view(np.uint8).reshape(self.shape))
        # only moved, never read as numbers
        moved = {1: np.uint8, 4: np.int32, 8: np.float64}
        merged = cv2.merge([n.view(moved[n.itemsize]).reshape(-1, 1) for n in numbers])
        return np.asarray(merged).view(np.uint8).reshape(self.shape)

    @cached_property
    def held(self) -> list[NDArray[Any]]:
        """The words of its frames where they lie in memory; waits for all arithmetic begun."""
        dr.eval(self.words)
        runs = self.shape[0] * self.shape[1] * self.shape[2] // len(self.colours[0])
        return [word.numpy()[-runs:] for word in self.words]

    @cached_property
    def words(self) -> list[Any]:
        """The bytes of a run in memory's order, R G B R G B ..., as many words as colours."""
        in_order = [code for pixel in zip(*self.colours, strict=True) for code in pixel]
        if len(in_order) < 4:
            return [self.arrays.UInt8(whole_number(code)) for code in in_order]
        codes = [whole_number(code) for code in in_order]
        words = [
            codes[k] | (codes[k + 1] << 8) | (codes[k + 2] << 16) | (codes[k + 3] << 24)
            for k in range(0, len(codes), 4)
        ]
        if len(words) == len(self.colours):
            return words
        wide = self.arrays.UInt64
        return [
            wide(low) | (wide(high) << 32)
            for low, high in zip(words[::2], words[1::2], strict=True)
        ]
