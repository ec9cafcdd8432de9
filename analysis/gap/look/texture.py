"""What is left of the mean image: its size, how far it reaches, and whether it is one-sided.

A shadow of dust or a ring of the wafer stands where no template can know; that there is something,
how large its pieces are and whether they are dark, a template does know.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FAMILY = "texture"
STAGE = "photosite"
CLIP = 8.0
"""Standard errors up to which a block of the residual image counts; more count as that."""


def texture(white: Floats, grid: tuple[int, int]) -> dict[str, float]:
    """Figures of one residual image in units of its standard error.

    Args:
        white: (blocks,), independent and of variance 1 where the model holds.
        grid: blocks down and across.
    """
    image = np.clip(white.reshape(grid), -CLIP, CLIP)
    power = float(np.square(image).mean()) + 1e-6
    found = {"residual power": float(np.log(power + 0.1))}
    for name, product in (
        ("across 1", image[:, 1:] * image[:, :-1]),
        ("down 1", image[1:] * image[:-1]),
        ("across 3", image[:, 3:] * image[:, :-3]),
    ):
        found[f"residual neighbours, {name}"] = float(product.mean()) / power
    found["residual skewness"] = float(np.mean(image * np.square(image))) / power**1.5
    found["residual outliers"] = float(np.sqrt((np.abs(image) > 4).mean()))
    return found
