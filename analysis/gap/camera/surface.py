"""A smooth surface through a picture that is even, as that of a flat is.

Lamps and lenses shade smoothly. What such a surface leaves of a flat is the camera's, or lies on
its window: see docs/decisions/an-even-picture-is-a-surface.md.

    sum of a_ij x^i y^j with i + j <= 6,    and    r^8, r^10, (x, y) r^6 and (x, y) r^8

The first is what lamps do, the rest what a lens does towards its corners, about an axis that need
not be in the middle: the fourth power of the cosine is such a sum to a thousandth up to 38 degrees.
"""

from __future__ import annotations

import functools

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy import signal

from analysis.gap.look.one_group import blocks

Floats = NDArray[np.float64]

DEGREE = 6
"""Of the polynomial that may have any shape."""

OF_A_LENS = ((0, 0, 4), (0, 0, 5), (1, 0, 3), (0, 1, 3), (1, 0, 4), (0, 1, 4))
"""Powers of y, of x and of r^2 in the rest."""

HIGHEST = 10
"""Degree of the whole."""

LOW = np.add.outer(np.arange(HIGHEST + 1), np.arange(HIGHEST + 1)) <= DEGREE
"""Which products of a polynomial down and one across are of no higher degree than the first."""

SHAPES = int(LOW.sum()) + len(OF_A_LENS)
"""How many there are; the first is even."""

BLOCKS = 24
"""Along the shorter side: the surface goes through means of them."""

EVEN = 0.01
"""What is left of an even picture, root mean square over its blocks, as a part of the mean. Patches
of the chart leave 0.4, a dozen shadows of dust of 3 % less than this."""


def surface_of(image: NDArray[np.float32]) -> NDArray[np.float32] | None:
    """The surface, (H, W, 3); None through any other picture, and where a channel is dark.

    Args:
        image: the picture, (H, W, 3).
    """
    height, width = image.shape[:2]
    side = max(1, min(height, width) // BLOCKS)
    seen = blocks(np.moveaxis(image, 2, 0), side)
    mean = seen.mean(axis=(1, 2))
    if (mean <= 0).any() or min(seen.shape[1:]) <= HIGHEST:
        return None
    down, across = (
        _polynomials(size)[:, : n * side].reshape(HIGHEST + 1, n, side).mean(axis=2)
        for size, n in zip((height, width), seen.shape[1:], strict=True)
    )
    shapes = _summed(_shapes(height, width), down, across).reshape(SHAPES, -1).T
    wanted = seen.reshape(3, -1).T
    found = np.asarray(np.linalg.lstsq(shapes, wanted, rcond=None)[0], dtype=np.float64)
    if np.sqrt(np.square((wanted - shapes @ found) / mean).mean()) > EVEN:
        return None
    return np.asarray(np.clip(laid(found, (height, width)), 0, None), dtype=np.float32)


def laid(amounts: Floats, shape: tuple[int, int]) -> Floats:
    """A surface of so much of each shape, (shapes, channels), on a picture: (H, W, channels)."""
    of_each = np.tensordot(amounts.T, _shapes(*shape), axes=1)
    return np.moveaxis(_summed(of_each, *map(_polynomials, shape)), 0, 2)


def _summed(amounts: Floats, down: Floats, across: Floats) -> Floats:
    """Sums of so much of each product, (n, degrees, degrees), as pictures (n, H, W)."""
    return np.asarray(down.T @ amounts @ across)


def _polynomials(size: int) -> Floats:
    """Legendre polynomials of a side of so many pixels, (degrees, size)."""
    return np.asarray(legendre.legvander(np.linspace(-1, 1, size), HIGHEST).T)


@functools.lru_cache(maxsize=4)
def _shapes(height: int, width: int) -> Floats:
    """The shapes as sums of products of Legendre polynomials, (shapes, degrees, degrees).

    What lenses do is laid without what the free ones are able to do: least of all is it a level.
    The squared distance from the middle is 1 in the corners.
    """
    of_powers = np.zeros(LOW.shape)
    for power, row in enumerate(of_powers):
        row[: power + 1] = legendre.poly2leg(np.eye(power + 1)[power])
    free = np.zeros((int(LOW.sum()), *LOW.shape))
    free[np.arange(len(free)), *np.nonzero(LOW)] = 1.0
    r2 = np.zeros((3, 3))
    r2[2, 0], r2[0, 2] = np.array([height**2, width**2]) / (height**2 + width**2)
    lenses = np.array([of_powers.T @ _lens(r2, *one) @ of_powers for one in OF_A_LENS])
    return np.concatenate([free, np.where(LOW, 0.0, lenses)])


def _lens(r2: Floats, y: int, x: int, times: int) -> Floats:
    """Coefficients of y^y x^x (r^2)^times by powers of y and of x, (degrees, degrees)."""
    made = np.zeros((HIGHEST + 1, HIGHEST + 1))
    product = functools.reduce(signal.convolve2d, [r2] * times)
    made[y : y + product.shape[0], x : x + product.shape[1]] = product
    return made
