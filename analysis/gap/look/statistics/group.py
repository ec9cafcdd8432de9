"""A group of frames on all lattices of a camera, with what every family needs computed once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float32]
Floats = NDArray[np.float64]
Figures = dict[str, Floats]
"""Figures by name, each of every lattice, (k,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Consecutive frames of one shot, lattice by lattice.

    Everything is an array over the lattices first: four lattices cost one call each, not four.

    Attributes:
        codes: pixel values as they are, (k, n, h, w): lattices, frames, rows, columns.
        top_dn: the largest value that the bits allow.
        lit: whether a lamp was on.
    """

    codes: NDArray[Any]
    top_dn: int
    lit: bool

    @property
    def frames(self) -> int:
        """Number of frames n."""
        return int(self.codes.shape[1])

    @property
    def pixels(self) -> int:
        """Samples h w of a lattice in one frame."""
        return int(np.prod(self.codes.shape[2:]))

    @cached_property
    def values(self) -> Array:
        """The pixel values in single precision."""
        return np.ascontiguousarray(self.codes, dtype=np.float32)

    @cached_property
    def _sums(self) -> tuple[Array, Array]:
        """Sums of the even and of the odd frames, (k, h, w) each."""
        return self.values[:, ::2].sum(axis=1), self.values[:, 1::2].sum(axis=1)

    @cached_property
    def mean(self) -> Array:
        """Mean over the frames, (k, h, w)."""
        even, odd = self._sums
        return (even + odd) / np.float32(self.frames)

    @cached_property
    def noise(self) -> Array:
        """What changes from frame to frame: values less their mean, (k, n, h, w)."""
        return self.values - self.mean[:, None]

    @cached_property
    def square(self) -> Array:
        """Square of the noise, (k, n, h, w)."""
        return np.square(self.noise)

    @cached_property
    def _energies(self) -> tuple[Array, Array]:
        """Sums of the square over the even and over the odd frames, (k, h, w) each."""
        return self.square[:, ::2].sum(axis=1), self.square[:, 1::2].sum(axis=1)

    @cached_property
    def energy(self) -> Array:
        """Square of the noise, summed over the frames, (k, h, w)."""
        even, odd = self._energies
        return even + odd

    @cached_property
    def energy_of_halves(self) -> tuple[Array, Array]:
        """Square of the even and of the odd frames less their own mean each, summed, (k, h, w):
        two looks at the noise of each pixel that have no frame in common.
        """
        (even, odd), (of_even, of_odd) = self._mean_halves, self._energies
        return (
            of_even - (self.frames + 1) // 2 * np.square(even - self.mean),
            of_odd - self.frames // 2 * np.square(odd - self.mean),
        )

    @cached_property
    def products(self) -> Floats:
        """Mean product of the noise of each two frames, in DN^2, (k, n, n)."""
        flat = self.noise.reshape(len(self.codes), self.frames, -1)
        return np.asarray(flat @ flat.swapaxes(1, 2), dtype=np.float64) / self.pixels

    @cached_property
    def variance(self) -> Floats:
        """Mean variance in time, unbiased, in DN^2, (k,)."""
        return np.asarray(np.trace(self.products, axis1=1, axis2=2)) / (self.frames - 1)

    @cached_property
    def rows(self) -> Floats:
        """Mean noise of each row of each frame, (k, n, h)."""
        width = self.codes.shape[3]
        means = self.noise @ np.full(width, 1 / width, np.float32)
        return np.asarray(means, dtype=np.float64)

    @cached_property
    def columns(self) -> Floats:
        """Mean noise of each column of each frame, (k, n, w)."""
        height = self.codes.shape[2]
        means = np.full(height, 1 / height, np.float32) @ self.noise
        return np.asarray(means, dtype=np.float64)

    @cached_property
    def halves(self) -> tuple[Array, Array]:
        """Means of the even and of the odd frames without their smooth part, (k, h, w): two looks
        at the fixed pattern whose noise in time is independent.
        """
        even, odd = self._mean_halves
        return high_pass(even), high_pass(odd)

    @cached_property
    def crossed_halves(self) -> tuple[Array, Array]:
        """Means of the even and of the odd frames without anything that is linear along the rows or
        along the columns, in DN, (k, h - 2, w - 2); see `crossed`.
        """
        even, odd = self._mean_halves
        return crossed(even), crossed(odd)

    @property
    def _mean_halves(self) -> tuple[Array, Array]:
        even, odd = self._sums
        return even / np.float32((self.frames + 1) // 2), odd / np.float32(self.frames // 2)


def high_pass(images: Array) -> Array:
    """Images (k, h, w) less their mean over 7 x 7 samples."""
    smooth = [cv2.blur(one, (7, 7), borderType=cv2.BORDER_REFLECT_101) for one in images]
    return np.asarray(images - np.array(smooth))


def crossed(images: Array) -> Array:
    """Second difference along the rows of the second difference along the columns, over 6.

    Shading and the upright edges of a chart vanish, its corners alone are left; independent samples
    keep their variance, as (1, -2, 1) squared twice over makes 36.
    """
    down = images[..., 2:, :] - 2 * images[..., 1:-1, :] + images[..., :-2, :]
    return np.asarray((down[..., 2:] - 2 * down[..., 1:-1] + down[..., :-2]) / 6.0)


def lagged(flat: Array, lag: int) -> Floats:
    """Mean product of samples that are `lag` places apart on the last axis.

    A lag of dy rows and dx columns of w is dy w + dx places of a stack in memory order. The few
    products that reach into the next row or frame are of samples that have nothing to do with each
    other, in real and simulated frames alike.
    """
    pairs = flat.shape[-1] - lag
    return np.asarray(np.vecdot(flat[..., lag:], flat[..., :pairs]) / np.float64(pairs))


def safe_ratio(a: ArrayLike, b: ArrayLike) -> Floats:
    """a / b, and 0 where b is 0: noise-free frames have no structure in their noise."""
    above, below = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    return np.asarray(above / np.where(below > 0, below, np.inf))
