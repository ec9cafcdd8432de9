"""A group of frames on one lattice, with what every family needs computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Consecutive frames of one shot on one lattice.

    Attributes:
        codes: pixel values as they are, (n, h, w).
        top_dn: the largest value that the bits allow.
        lit: whether a lamp was on.
    """

    codes: NDArray[Any]
    top_dn: int
    lit: bool

    @cached_property
    def values(self) -> Array:
        """The pixel values in single precision."""
        return np.ascontiguousarray(self.codes, dtype=np.float32)

    @cached_property
    def mean(self) -> Array:
        """Mean over the frames, (h, w)."""
        return np.asarray(self.values.mean(axis=0), dtype=np.float32)

    @cached_property
    def noise(self) -> Array:
        """What changes from frame to frame: values less their mean, (n, h, w)."""
        return self.values - self.mean

    @cached_property
    def energy(self) -> Array:
        """Square of the noise, summed over the frames, (h, w)."""
        return np.asarray(np.einsum("nhw,nhw->hw", self.noise, self.noise))

    @cached_property
    def variance(self) -> float:
        """Mean variance in time, unbiased, in DN^2."""
        return float(self.energy.mean(dtype=np.float64)) / (len(self.values) - 1)

    @cached_property
    def halves(self) -> tuple[Array, Array]:
        """Means of the even and of the odd frames without their smooth part: two looks at the
        fixed pattern whose noise in time is independent.
        """
        return high_pass(self.values[::2].mean(axis=0)), high_pass(self.values[1::2].mean(axis=0))

    @cached_property
    def crossed_halves(self) -> tuple[Array, Array]:
        """The same without anything that is linear along the rows or along the columns."""
        return crossed(self.values[::2].mean(axis=0)), crossed(self.values[1::2].mean(axis=0))


def high_pass(image: Array) -> Array:
    """An image less its mean over 7 x 7 samples."""
    return np.asarray(image - cv2.blur(image, (7, 7), borderType=cv2.BORDER_REFLECT_101))


def crossed(image: Array) -> Array:
    """Second difference along the rows of the second difference along the columns, over 6.

    Shading and the upright edges of a chart vanish, its corners alone are left; independent samples
    keep their variance, as (1, -2, 1) squared twice over makes 36.
    """
    down = image[2:] - 2 * image[1:-1] + image[:-2]
    return np.asarray((down[:, 2:] - 2 * down[:, 1:-1] + down[:, :-2]) / 6.0)


def lagged(stack: NDArray[np.float32], lag: int) -> float:
    """Mean product of samples that are `lag` places apart in memory order.

    A lag of dy rows and dx columns is dy w + dx places. The few products that reach into the next
    row or frame are of samples that have nothing to do with each other, in real and simulated
    frames alike.
    """
    flat = stack.ravel()
    return float(np.dot(flat[lag:], flat[: flat.size - lag])) / (flat.size - lag)


def safe_ratio(a: float, b: float) -> float:
    """a / b, and 0 where b is 0: noise-free frames have no structure in their noise."""
    return a / b if b > 0 else 0.0
