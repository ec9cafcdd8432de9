"""Figures of one kind: one statistic in all lattices and shots where it means the same."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.observation import Key


@functools.lru_cache(maxsize=8)
def kinds(keys: tuple[Key, ...], lit: frozenset[str]) -> tuple[NDArray[np.intp], ...]:
    """Places of the figures of each kind: of all lit shots, or of all others, where a statistic may
    have another unit.

    Args:
        keys: of the figures.
        lit: labels of the shots with a lamp on.
    """
    places: dict[tuple[str, str, bool], list[int]] = {}
    for place, key in enumerate(keys):
        places.setdefault((key.family, key.statistic, key.shot in lit), []).append(place)
    return tuple(np.array(own) for own in places.values())
