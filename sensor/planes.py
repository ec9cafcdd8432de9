"""Three colours side by side: how an image is held until somebody needs its pixels.

Writing red, green and blue alternately costs as much time as drawing the random numbers of the
frame. Rounding and clipping do not need it, and the last step to bytes is cheap; so a demosaicer
gives planes, and they are interleaved at the first look at the pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.neighbours import interleaved


@dataclass(frozen=True, kw_only=True, eq=False)
class Planes:
    """The red, green and blue values of a batch of frames.

    Attributes:
        colours: three flat Dr.Jit arrays of f H W values each.
        shape: (f, H, W, 3).
        kind: the type of tensor that holds them together.
    """

    colours: tuple[Any, Any, Any]
    shape: tuple[int, int, int, int]
    kind: Any

    def map(self, change: Callable[[Any], Any]) -> Planes:
        """The planes after a change that looks at each number by itself."""
        red, green, blue = self.colours
        colours = (change(red), change(green), change(blue))
        return Planes(colours=colours, shape=self.shape, kind=self.kind)

    @cached_property
    def tensor(self) -> Any:
        """The same numbers pixel by pixel: a tensor (f, H, W, 3)."""
        return self.kind(interleaved(list(self.colours)), self.shape)

    def as_bytes(self, whole: Any) -> NDArray[np.uint8]:
        """Codes of 0 to 255 as bytes, pixel by pixel: (f, H, W, 3).

        Args:
            whole: the Dr.Jit array type of bytes.
        """
        import cv2

        colours = [whole(plane) for plane in self.colours]
        dr.eval(colours)
        lines = (self.shape[0] * self.shape[1], self.shape[2])
        merged = cv2.merge([np.asarray(plane.numpy()).reshape(lines) for plane in colours])
        return np.asarray(merged, dtype=np.uint8).reshape(self.shape)
