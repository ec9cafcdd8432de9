"""A smooth surface through a picture that is even, as that of a flat is.

Lamps and lenses shade smoothly. What such a surface leaves of a flat is the camera's, or lies on
its window: see docs/decisions/an-even-picture-is-a-surface.md.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from analysis.gap.look.one_group import blocks

DEGREE = 10
"""Of the polynomial: the fourth power of the cosine, by which a lens darkens its corners, is one to
a thousandth up to 38 degrees. One of the sixth degree is off by 2 % there."""

LOW = np.add.outer(np.arange(DEGREE + 1), np.arange(DEGREE + 1)) <= DEGREE
"""Which products of a polynomial down and one across are of no higher degree."""

PRODUCTS = int(LOW.sum())
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
    if (mean <= 0).any() or min(seen.shape[1:]) <= DEGREE:
        return None
    down, across = (
        _polynomials(size)[:, : n * side].reshape(DEGREE + 1, n, side).mean(axis=2)
        for size, n in zip((height, width), seen.shape[1:], strict=True)
    )
    products = np.einsum("iy,jx->yxij", down, across)[..., LOW].reshape(-1, PRODUCTS)
    wanted = seen.reshape(3, -1).T
    found = np.linalg.lstsq(products, wanted, rcond=None)[0]
    if np.sqrt(np.square((wanted - products @ found) / mean).mean()) > EVEN:
        return None
    return np.asarray(np.clip(laid(found, (height, width)), 0, None), dtype=np.float32)


def laid(amounts: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.float64]:
    """A surface of so much of each product, (products, channels), on a picture of this shape."""
    of_each = np.zeros((*LOW.shape, amounts.shape[1]))
    of_each[LOW] = amounts
    down, across = (_polynomials(size) for size in shape)
    return np.asarray(np.einsum("iy,jx,ijc->yxc", down, across, of_each, optimize=True))


def _polynomials(size: int) -> NDArray[np.float64]:
    """Legendre polynomials of a side of so many pixels, (DEGREE + 1, size)."""
    return np.asarray(legendre.legvander(np.linspace(-1, 1, size), DEGREE).T)
