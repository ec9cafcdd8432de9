"""Powers of positive numbers with any exponent: x^p = 2^(p log2 x).

Both functions are polynomials without the cases of a library's: a third of the time. Each is right
to 2e-7, a few roundings of a float32, the logarithm absolutely where x is far from 1.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import drjit as dr
import numpy as np

from sensor.limits import at_least
from sensor.polynomials import horner, interpolated

ROOT_HALF = 0x3F3504F3
"""sqrt(1/2) as the bits of a float32: where the mantissa's range is cut."""


def split(x: Any) -> tuple[Any, Any]:
    """e and f of x = 2^e (1 + f) with 1 + f between sqrt(1/2) and sqrt(2), for x > 0."""
    kind: Any = type(x)
    bits: Any = dr.reinterpret_array
    above = bits(dr.int32_array_t(kind), x) - ROOT_HALF
    return kind(above >> 23), bits(kind, (above & 0x7FFFFF) + ROOT_HALF) - 1.0


def power(x: Any, exponent: Any) -> Any:
    """x^exponent of flat arrays, for x > 0 and results below 2^127; below 2^-126 it is that."""
    logarithm, _ = _polynomials()
    e, f = split(x)
    return two_to(exponent * dr.fma(f, horner(logarithm, f), e))


def two_to(octaves: Any) -> Any:
    """2^octaves of flat arrays, for octaves below 127; below -126 it is 2^-126."""
    kind: Any = type(octaves)
    whole: Any = dr.int32_array_t(kind)
    bits: Any = dr.reinterpret_array
    _, doubling = _polynomials()
    octaves = at_least(octaves, -126.0)
    nearest = dr.round(octaves)
    mantissa = horner(doubling, octaves - nearest)
    return bits(kind, bits(whole, mantissa) + (whole(nearest) << 23))


@cache
def _polynomials() -> tuple[tuple[float, ...], ...]:
    """Coefficients of log2(1+f)/f in f, and of 2^x in x from -1/2 to 1/2."""
    low, high = np.sqrt(0.5) - 1.0, np.sqrt(2.0) - 1.0
    return (
        interpolated(lambda f: np.log1p(f) / (f * np.log(2.0)), low, high, 7),
        interpolated(np.exp2, -0.5, 0.5, 5),
    )
