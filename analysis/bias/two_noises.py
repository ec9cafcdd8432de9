"""The two noises that the parameters come from, without errors, rows and columns.

What `analysis.estimators.parts.panel_noise` measures, at a third of the work, for cells of many
bodies whose scatter is their error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.panel_noise import parabola_basis


def two_noises(lattices: Sequence[NDArray[Any]]) -> tuple[float, float, float]:
    """Mean, mu(sigma_t) and sigma(mu_t) of a panel in its unit, lattices (N, h, w) pooled."""
    parts = np.array([_of_lattice(stack) for stack in lattices])
    weight = np.array([stack.shape[1] * stack.shape[2] for stack in lattices], dtype=np.float64)
    mean, temporal, square = (weight / weight.sum()) @ parts
    return float(mean), float(temporal), float(square**0.5)


def _of_lattice(stack: NDArray[Any]) -> tuple[float, float, float]:
    n, h, w = stack.shape
    base = int(np.rint(stack.mean()))
    d = stack.astype(np.float32)
    d -= base
    image = d.mean(axis=0, dtype=np.float64)
    squares = np.einsum("fij,fij->ij", d, d, dtype=np.float64)
    variance = np.maximum(squares - n * image**2, 0.0) / (n - 1)
    down = parabola_basis(h)
    left = image - down @ (down.T @ image)
    return (
        base + float(image.mean()),
        float(np.sqrt(variance).mean()),
        float(np.sum(left * left) / (h * w - 1)),
    )
