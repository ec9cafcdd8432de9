"""A picture that is made where somebody looks, because it is elsewhere in every frame.

Behind a mosaic of colour filters a third of it is seen; the rest need not be made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

import drjit as dr

from sensor.neighbours import Places, interleaved, run_length
from sensor.planes import Planes


@dataclass(frozen=True, kw_only=True, eq=False)
class Sampled:
    """Three colours of a batch of frames.

    Attributes:
        make: the columns of runs by colour, from where the runs are and which colours, each an
            index from 0 to 2 or one for every run, are looked at.
        shape: (f, H, W, 3).
        arrays: the Dr.Jit module they are of.
    """

    make: Callable[[Places, Sequence[Any]], list[list[Any]]]
    shape: tuple[int, ...]
    arrays: ModuleType

    @cached_property
    def tensor(self) -> Any:
        """All colours of every pixel: a tensor of the shape."""
        places = self._places()
        planes = [interleaved(columns) for columns in self.make(places, (0, 1, 2))]
        return self.arrays.TensorXf(interleaved(planes), self.shape)

    def mosaic(self, cfa: str) -> Planes:
        """The colour that each pixel sees, from those of the pixels (0,0) (0,1) (1,0) (1,1)."""
        places = self._places()
        index = type(places.row)
        code = [index("RGB".index(colour)) for colour in cfa]
        odd_row = (places.row & 1) == 1
        even, odd = (dr.select(odd_row, code[2 + column], code[column]) for column in (0, 1))
        if places.length == 1:
            (seen,) = self.make(places, [dr.select(places.odd_column(0), odd, even)])
        else:
            both = self.make(places, (even, odd))
            seen = [both[k % 2][k] for k in range(places.length)]
        return Planes(colours=(tuple(seen),), shape=self.shape[:3], arrays=self.arrays)

    def _places(self) -> Places:
        return Places(self.arrays, self.shape, run_length(self.arrays, self.shape[2]))
