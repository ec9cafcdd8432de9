"""Intervals for shares and medians of few cases.

[1] E. B. Wilson, J. Am. Stat. Assoc. 22, 209 (1927).
[2] R. G. Newcombe, Stat. Med. 17, 873 (1998), method 10: the difference of two shares.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy import stats

from analysis.gap_bench.share import Share

CONFIDENCE = 0.95

Interval = tuple[float, float]


def wilson(hits: int, tries: int) -> Interval:
    """Interval of a share [1]; 0 to 1 where nothing was tried."""
    return Share(hits=hits, cases=tries).interval


def difference(one: tuple[int, int], two: tuple[int, int]) -> Interval:
    """Interval of the first share less the second [2]; each is hits and tries."""
    (a, b), (low_a, high_a), (low_b, high_b) = _shares(one, two), wilson(*one), wilson(*two)
    return (
        a - b - math.hypot(a - low_a, high_b - b),
        a - b + math.hypot(high_a - a, b - low_b),
    )


def _shares(one: tuple[int, int], two: tuple[int, int]) -> tuple[float, float]:
    return one[0] / max(1, one[1]), two[0] / max(1, two[1])


def of_median(values: Sequence[float]) -> Interval | None:
    """Interval of a median from order statistics; None where six values are not there.

    With fewer, not even the smallest and the largest enclose the median often enough.
    """
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    n = len(ordered)
    rank = int(stats.binom.ppf((1 - CONFIDENCE) / 2, n, 0.5)) if n else 0
    # the ends are the ranks `rank` and n + 1 - rank: outside lie at most 2.5 % on each side
    while rank > 0 and stats.binom.cdf(rank - 1, n, 0.5) > (1 - CONFIDENCE) / 2:
        rank -= 1
    return None if rank == 0 else (float(ordered[rank - 1]), float(ordered[n - rank]))
