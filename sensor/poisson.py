"""Poisson counts from one standard normal number w each, without rejection.

Below `SMALL_MEAN` the distribution function is summed until it passes the probability of w: exact.
Where all pixels have one mean, as in the dark, the normal numbers at which that happens are known
before any is drawn, and a count is how many of them w reaches. Above, the count is the integer part
of the Poisson quantile's expansion in the normal one w,

    Q(w) = m + w sqrt(m) + (1/3 + w^2/6) - (w/36 + w^3/72)/sqrt(m)
             + (-8/405 + 7 w^2/810 + w^4/270)/m

(Giles, "Approximation of the inverse Poisson cumulative distribution function", ACM TOMS 42, 2016,
equation for Q_N3). The distribution function of such counts is off by at most 3.1e-5 at mean 12,
1.5e-6 at mean 50, and their mean by 3e-7 e- at most.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np
from scipy import special

from sensor.limits import at_least

SMALL_MEAN = 12.0
"""Mean in e- from which the expansion is used."""

_NEGLIGIBLE = 2.0**-26
"""A probability that no longer changes a sum near 1. The normal number's own probability is rounded
to 1 from 5.4 standard deviations on, which no sum passes: there the sum ends with its terms."""


def poisson_count(mean: Any, normal: Any, least: float = 0.0) -> Any:
    """Counts with the given means, flat arrays, from standard normal numbers of the same size.

    Args:
        mean: means in e-.
        normal: standard normal numbers.
        least: a bound that no mean lies below; from `SMALL_MEAN` on, the sum need not be made.
    """
    large = large_mean_quantile(mean, normal)
    if least >= SMALL_MEAN:
        return large
    small = small_mean_count(mean, 0.5 + 0.5 * dr.erf(normal * math.sqrt(0.5)))
    return dr.select(mean < SMALL_MEAN, small, large)


HIGHEST = 6.75
"""Standard normal numbers are below it; see `sensor/box_muller.py`."""


@functools.lru_cache(maxsize=64)
def steps_of(mean: float) -> tuple[float, ...]:
    """The normal numbers from which a count of a small mean is 1 or more, 2 or more, and so on.

    As many as a power of two, so that few kernels serve all means; the last ones are never reached.

    Args:
        mean: in e-, below `SMALL_MEAN`.
    """
    number = 4
    # from the upper end, where a float has all digits of what is left of 1
    while -special.ndtri(special.pdtrc(number - 1, mean)) < HIGHEST:
        number *= 2
    return tuple((-special.ndtri(special.pdtrc(np.arange(number), mean))).tolist())


def steps_reached(steps: Sequence[Any], normal: Any) -> Any:
    """Counts of one mean: how many of its steps standard normal numbers reach.

    Args:
        steps: of `steps_of`, as numbers or as data of a kernel.
        normal: standard normal numbers, a flat array.
    """
    return functools.reduce(
        lambda count, step: count + dr.select(normal >= step, 1.0, 0.0),
        steps,
        dr.zeros(type(normal), dr.width(normal)),
    )


def large_mean_quantile(mean: Any, normal: Any) -> Any:
    """Counts from standard normal numbers; only right for means of `SMALL_MEAN` and more."""
    m = at_least(mean, SMALL_MEAN)
    w, w2, root = normal, normal * normal, dr.sqrt(m)
    first = dr.fma(w2, 1 / 6, 1 / 3)
    second = w * dr.fma(w2, -1 / 72, -1 / 36)
    third = dr.fma(w2, dr.fma(w2, 1 / 270, 7 / 810), -8 / 405)
    inverse = dr.rcp(root)
    q = dr.fma(w, root, m) + dr.fma(inverse, dr.fma(inverse, third, second), first)
    return at_least(dr.floor(q), 0.0)


def small_mean_count(mean: Any, uniform: Any) -> Any:
    """Counts from uniform numbers by summing the distribution function; for small means."""
    m = dr.clip(mean, 0.0, SMALL_MEAN)
    term = dr.exp(-m)
    active = (mean < SMALL_MEAN) & (mean > 0.0)

    def go_on(count: Any, term: Any, total: Any, mean: Any) -> Any:
        return active & (uniform >= total) & (term > _NEGLIGIBLE)

    def step(count: Any, term: Any, total: Any, mean: Any) -> tuple[Any, Any, Any, Any]:
        count = count + 1.0
        term = term * mean / count
        return count, term, total + term, mean

    start = (dr.zeros(type(mean), dr.width(mean)), term, term, m)
    return dr.while_loop(start, go_on, step, labels=("count", "term", "total", "mean"))[0]
