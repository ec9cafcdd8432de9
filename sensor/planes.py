"""Three colours side by side: how an image is held until somebody needs its pixels.

Writing red, green and blue alternately costs as much time as drawing the random numbers of the
frame. Rounding and clipping do not need it, and the last step to bytes is cheap; so a demosaicer
gives planes, and they are interleaved at the first look at the pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.neighbours import interleaved, run_length


@dataclass(frozen=True, kw_only=True, eq=False)
class Planes:
    """The red, green and blue values of a batch of frames.

    Attributes:
        colours: for each colour, its values as 1 flat Dr.Jit array of f H W, or as 4 of a quarter
            of that, which hold every fourth column each: the runs of `sensor.neighbours.Runs`.
        shape: (f, H, W, 3).
        arrays: the Dr.Jit module they are of.
    """

    colours: tuple[tuple[Any, ...], ...]
    shape: tuple[int, ...]
    arrays: ModuleType

    @classmethod
    def of(cls, tensor: Any, arrays: ModuleType) -> Planes:
        """The planes of numbers that lie pixel by pixel: a tensor (f, H, W, 3)."""
        flat, shape = tensor.array, tuple(tensor.shape)
        dr.eval(flat)
        length = run_length(arrays, shape[2])
        lane = dr.arange(dr.uint32_array_t(type(flat)), dr.width(flat) // (3 * length))
        kind = arrays.Array4f if length == 4 else type(flat)
        fetched = [dr.gather(kind, flat, 3 * lane + k) for k in range(3)]
        numbers = [n for pack in fetched for n in pack] if length == 4 else fetched
        return cls(
            colours=tuple(tuple(numbers[c::3]) for c in range(3)), shape=shape, arrays=arrays
        )

    def map(self, change: Callable[[Any], Any]) -> Planes:
        """The planes after a change that looks at each number by itself."""
        colours = tuple(tuple(change(part) for part in parts) for parts in self.colours)
        return Planes(colours=colours, shape=self.shape, arrays=self.arrays)

    @cached_property
    def tensor(self) -> Any:
        """The same numbers pixel by pixel: a tensor (f, H, W, 3)."""
        planes = [interleaved(list(parts)) for parts in self.colours]
        return self.arrays.TensorXf(interleaved(planes), self.shape)

    def as_bytes(self) -> NDArray[np.uint8]:
        """Codes of 0 to 255 as bytes, pixel by pixel: (f, H, W, 3). For a JIT backend."""
        import cv2

        planes = [self._bytes_of(parts) for parts in self.colours]
        dr.eval(planes)
        lines = (self.shape[0] * self.shape[1], self.shape[2])
        merged = cv2.merge([plane.numpy().view(np.uint8).reshape(lines) for plane in planes])
        return np.asarray(merged, dtype=np.uint8).reshape(self.shape)

    def _bytes_of(self, parts: tuple[Any, ...]) -> Any:
        """The bytes of one colour in memory's order: by themselves, or four in a word."""
        if len(parts) == 1:
            return self.arrays.UInt8(parts[0])
        words = [self.arrays.UInt32(part) for part in parts]
        return words[0] | (words[1] << 8) | (words[2] << 16) | (words[3] << 24)
