"""What figures of one shot have in common, which each would count by itself.

A level that wanders down the rows makes neighbours of every lag, codes, tails and means of frames
differ at once, in one shot more and in the next one less. Twins show it: of p standardized figures
in n twins and shots the covariance has eigenvalues up to (1 + sqrt(p / n))^2 by chance, as
Marchenko and Pastur found, and what is beyond is in common. The rest of each figure is its own.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.observation import Key

Floats = NDArray[np.float64]

LEAST_OWN = 0.03
"""Part of a figure's variance that is its own in any case."""


def correlations(
    keys: Sequence[Key], twins: Floats, of_chance: Floats
) -> Iterator[tuple[NDArray[np.intp], Floats]]:
    """Places of figures that have something in common, of each shot, and their correlation.

    Args:
        keys: of the figures.
        twins: their differences from what is expected in standard errors, (twins, figures).
        of_chance: part of each figure's variance that is what twins show; the rest is its own.
    """
    for places in _alike(keys):
        shots = np.array(places)
        samples = twins[:, shots].reshape(-1, shots.shape[1])
        one = correlation(samples, (len(twins) - 1) * len(shots))
        if one is None:
            continue
        for place in shots:
            part = np.sqrt(of_chance[place])
            yield place, one * np.outer(part, part) + np.diag(1.0 - of_chance[place])


def correlation(samples: Floats, count: int) -> Floats | None:
    """What columns of samples have in common, as a correlation; None where that is chance.

    Args:
        samples: standardized, (n, p).
        count: their degrees of freedom.
    """
    covariance = samples.T @ samples / count
    values, vectors = np.linalg.eigh(covariance)
    size = values.mean()
    beyond = values > (1.0 + np.sqrt(samples.shape[1] / count)) ** 2 * size
    if size <= 0 or not beyond.any():
        return None
    rest = values[~beyond].mean() if not beyond.all() else 0.0
    shared = (vectors * np.where(beyond, values - rest, 0.0)) @ vectors.T
    whole = np.diag(covariance)
    # a figure that no twin moved has nothing in common with any
    own = np.where(whole > 0, np.maximum(whole - np.diag(shared), LEAST_OWN * whole), 1.0)
    found = shared + np.diag(own)
    width = np.sqrt(np.diag(found))
    return np.asarray(found / np.outer(width, width))


def _alike(keys: Sequence[Key]) -> Iterator[list[list[int]]]:
    """Places of the figures of each shot, (shots, figures), of shots with the same ones."""
    of_shots: dict[str, list[int]] = defaultdict(list)
    for place, key in enumerate(keys):
        of_shots[key.shot].append(place)
    alike: dict[tuple[tuple[str, str, str], ...], list[list[int]]] = defaultdict(list)
    for places in of_shots.values():
        own = [keys[place] for place in places]
        alike[tuple((k.family, k.lattice, k.statistic) for k in own)].append(places)
    yield from alike.values()
