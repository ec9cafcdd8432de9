"""Frames that repeat the one before are counted, and then left out.

They tell of the cable, not of the sensor. Left in, they would look like a filter over time: two
equal frames are as correlated as frames can be.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def repeats(dn: NDArray[Any]) -> NDArray[np.bool_]:
    """Which of (n, ...) frames equals the one before in every pixel; the first does not."""
    return np.array([k > 0 and _same(dn[k], dn[k - 1]) for k in range(len(dn))])


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Whether two frames are equal; the first row of most tells that they are not."""
    return np.array_equal(one[0], other[0]) and np.array_equal(one, other)


def fresh(dn: NDArray[Any], frames: int) -> NDArray[Any]:
    """So many frames without the repeats; where too few are left, from the first one again."""
    own = np.flatnonzero(~repeats(dn))
    if len(own) == len(dn):
        return np.asarray(dn[:frames])
    return np.asarray(dn[np.resize(own, frames)])
