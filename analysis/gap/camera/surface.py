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
    side = max(1, min(image.shape[:2]) // BLOCKS)
    seen = blocks(np.moveaxis(image, 2, 0), side)
    mean = seen.mean(axis=(1, 2))
    if (mean <= 0).any() or min(seen.shape[1:]) <= DEGREE:
        return None
    pixels = [np.arange(n) for n in image.shape[:2]]
    middles = [side * np.arange(n) + (side - 1) / 2 for n in seen.shape[1:]]
    rows, columns, down, across = (
        2 * at / (n - 1) - 1 for at, n in zip(pixels + middles, 2 * image.shape[:2], strict=True)
    )
    y, x = np.meshgrid(down, across, indexing="ij")
    products = legendre.legvander2d(y, x, [DEGREE, DEGREE])[..., LOW.ravel()]
    products, wanted = products.reshape(-1, products.shape[-1]), seen.reshape(3, -1).T
    found = np.linalg.lstsq(products, wanted, rcond=None)[0]
    if np.sqrt(np.square((wanted - products @ found) / mean).mean()) > EVEN:
        return None
    amounts = np.zeros((*LOW.shape, 3))
    amounts[LOW] = found
    surface = np.moveaxis(legendre.leggrid2d(rows, columns, amounts), 0, 2)
    return np.asarray(np.clip(surface, 0, None), dtype=np.float32)
