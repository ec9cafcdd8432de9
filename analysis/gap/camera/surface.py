"""A smooth surface through a picture that is even, as that of a flat is.

Lamps and lenses shade smoothly. What such a surface leaves of a flat is the camera's, or lies on
its window: see docs/decisions/an-even-picture-is-a-surface.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from analysis.gap.look.one_group import blocks

Floats = NDArray[np.float64]

DEGREE = 10
"""Of the polynomial: the fourth power of the cosine, by which a lens darkens its corners, is one to
a thousandth up to 38 degrees. One of the sixth degree is off by 2 % there."""

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
    size = image.shape[:2]
    side = max(1, min(size) // BLOCKS)
    seen = blocks(np.moveaxis(image, 2, 0), side)
    mean = seen.mean(axis=(1, 2))
    if (mean <= 0).any() or min(seen.shape[1:]) <= DEGREE:
        return None
    down, across = (np.arange(count) * side + (side - 1) / 2 for count in seen.shape[1:])
    columns = _columns(down, across, size)
    wanted = seen.reshape(3, -1).T
    found = np.linalg.lstsq(columns, wanted, rcond=None)[0]
    if np.sqrt(np.square((wanted - columns @ found) / mean).mean()) > EVEN:
        return None
    surface = _columns(np.arange(size[0]), np.arange(size[1]), size) @ found
    return np.clip(surface, 0, None).astype(np.float32).reshape(image.shape)


def _columns(rows: NDArray[Any], columns: NDArray[Any], size: tuple[int, ...]) -> Floats:
    """Products of Legendre polynomials up to the degree at pixels, (pixels, products)."""
    down, across = (2 * at / (n - 1) - 1 for at, n in zip((rows, columns), size, strict=True))
    products = legendre.legvander2d(*np.meshgrid(down, across, indexing="ij"), [DEGREE, DEGREE])
    i, j = np.divmod(np.arange((DEGREE + 1) ** 2), DEGREE + 1)
    return np.asarray(products[..., i + j <= DEGREE].reshape(-1, int((i + j <= DEGREE).sum())))
