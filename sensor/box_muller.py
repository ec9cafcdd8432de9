"""Two independent standard normal numbers from two random words, by the Box-Muller transform.

    n_1 = r cos(theta),  n_2 = r sin(theta),  r = sqrt(-2 ln u),  theta = 2 pi v

u in (0, 1] has 32 bits, so that numbers reach 6.7 standard deviations. Logarithm, sine and cosine
are polynomials for just the range that occurs, without the cases of a library's: half the time.
Each is right to 2e-7, a few roundings of a float32.

Reference: Box and Muller, "A note on the generation of random normal deviates", 1958.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import drjit as dr
import numpy as np

from sensor.philox import Words
from sensor.polynomials import horner, interpolated
from sensor.powers import split


def normals(four: Words) -> list[Any]:
    """Four standard normal numbers from four words."""
    return [*_pair(four[0], four[2]), *_pair(four[1], four[3])]


def _pair(turn: Any, height: Any) -> tuple[Any, Any]:
    kind: Any = type(turn)
    number: Any = dr.float32_array_t(kind)
    signed: Any = dr.int32_array_t(kind)
    bits: Any = dr.reinterpret_array
    logarithm, sine, cosine = _polynomials()

    e, f = split(dr.fma(number(~height), number(2.0**-32), number(2.0**-33)))
    r = dr.sqrt(dr.fma(e, number(-2.0 * math.log(2.0)), f * horner(logarithm, f)))

    # theta = pi/2 t, plus pi where the upper two bits of v differ: both numbers change their sign
    double = turn << 1
    r = bits(number, bits(kind, r) ^ ((turn ^ double) & 0x80000000))
    t = number(bits(signed, double)) * 2.0**-31
    square = t * t
    return r * horner(cosine, square), r * t * horner(sine, square)


@cache
def _polynomials() -> tuple[tuple[float, ...], ...]:
    """Coefficients from the constant up.

    -2 ln(1+f)/f in f, sin(pi t/2)/t in t^2, cos(pi t/2) in t^2.
    """
    low, high = math.sqrt(0.5) - 1.0, math.sqrt(2.0) - 1.0
    return (
        interpolated(lambda f: -2.0 * np.log1p(f) / f, low, high, 7),
        interpolated(lambda x: np.sin(np.pi / 2 * np.sqrt(x)) / np.sqrt(x), 0.0, 1.0, 4),
        interpolated(lambda x: np.cos(np.pi / 2 * np.sqrt(x)), 0.0, 1.0, 4),
    )
