"""Frames that repeat the one before are counted, and then left out.

They tell of the cable, not of the sensor. Left in, they would look like a filter over time: two
equal frames are as correlated as frames can be. Frames that repeat some rows of the one before, as
where a picture was handed over before all of it was there, are counted as well, and stay.
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


WITNESS = 40
"""Pixels of a row that change from a frame to the next, in most of them, from which none of them
changes by no chance: of noise that changes every tenth pixel of 400, once in 10^18 rows."""

FIRST = 32
"""Pixels that say of most rows that they do not repeat."""


def partly_repeats(dn: NDArray[Any]) -> NDArray[np.bool_]:
    """Which of (n, height, width, ...) frames have rows of the one before, to the last code, among
    others that are their own. Rows that hardly ever change tell nothing.
    """
    found = np.zeros(len(dn), dtype=bool)
    start = dn[:, :, :FIRST].reshape(*dn.shape[:2], -1)
    rows = np.flatnonzero((start[1:] == start[:-1]).all(axis=2).any(axis=0))
    if len(rows) == 0:
        return found
    differ = (dn[1:, rows] != dn[:-1, rows]).reshape(len(dn) - 1, len(rows), dn.shape[2], -1)
    changed = differ.any(axis=3).sum(axis=2)
    witness = np.median(changed, axis=0) >= WITNESS
    found[1:] = ((changed == 0) & witness).any(axis=1)
    return found & ~repeats(dn)


def fresh(dn: NDArray[Any], frames: int) -> NDArray[Any]:
    """So many frames without the repeats; where too few are left, from the first one again."""
    own = np.flatnonzero(~repeats(dn))
    if len(own) == len(dn):
        return np.asarray(dn[:frames])
    return np.asarray(dn[np.resize(own, frames)])
