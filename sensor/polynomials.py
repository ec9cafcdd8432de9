"""Smooth functions on a short range as polynomials: what a logarithm or a sine costs at least."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np


def interpolated(
    function: Callable[[Any], Any], low: float, high: float, degree: int
) -> tuple[float, ...]:
    """Coefficients from the constant up of the polynomial through a function of NumPy arrays.

    It is interpolated at Chebyshev nodes, which is within a small factor of the best there is.
    """
    series = np.polynomial.Chebyshev.interpolate(function, degree, domain=[low, high])
    return tuple(float(c) for c in series.convert(kind=np.polynomial.Polynomial).coef)


def horner(coefficients: tuple[float, ...], x: Any) -> Any:
    """The polynomial at x."""
    kind: Any = type(x)
    total = kind(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = dr.fma(total, x, kind(coefficient))
    return total
