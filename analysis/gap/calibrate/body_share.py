"""Which part of a figure's scatter is the camera body's, and no number of frames averages away.

    share = cov(first look, second look) / variance

A figure of noise in time differs from one group of frames to the next. Where noise is less than a
step of the converter it differs between bodies as well: what rounding does to a sample depends on
the fixed offset that it has.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.families import OF_A_BODY
from analysis.gap.look.kinds import kinds
from analysis.gap.look.observation import Key, Observation

Floats = NDArray[np.float64]

NEVER_AVERAGED = frozenset({"level", "dark surface"})
"""Families whose share is taken as 1: it differs from shot to shot, so that figures of one kind do
not have it together. With a measured one the surface of darks had p = 0.001 on one null of 20."""

USUAL = 0.1
"""Share of noise in time where nobody has looked twice: on 36 nulls its chi-squared was 1.03 to
1.22 times what independent groups of frames would give."""

BORROWED = 8.0
"""Figures of as many bodies that speak for the usual share."""


def usual_share(keys: tuple[Key, ...]) -> Floats:
    """The share of each figure, before it is measured: all of what is a body's by its name."""
    return np.where([key.family in OF_A_BODY for key in keys], 1.0, USUAL)


def body_share(first: Observation, again: Observation) -> Floats:
    """The share of each figure, from several bodies that were looked at twice.

    Figures of one kind have it together.

    Args:
        first: a group of frames of each body.
        again: another one of each, with the same keys.
    """
    one, two = (seen.figures - seen.figures.mean(axis=0) for seen in (first, again))
    count = first.groups
    variance = (np.square(one) + np.square(two)).sum(axis=0) / (2 * (count - 1))
    common = (one * two).sum(axis=0) / (count - 1)
    share = usual_share(first.keys)
    for places in kinds(first.keys, first.lit):
        moved = places[variance[places] > 0]
        if first.keys[places[0]].family in NEVER_AVERAGED or not moved.size:
            continue
        found = float(np.mean(common[moved] / variance[moved]))
        weight, usual = len(moved) * count, float(share[places[0]])
        share[places] = np.clip((weight * found + BORROWED * usual) / (weight + BORROWED), 0, 1)
    return share


PAIRS = 4.0
"""Bodies looked at twice whose word the figures' own shares count for."""


def share_of_amounts(first: Floats, again: Floats, by_figures: Floats) -> Floats:
    """Part of the variance of amounts that is the body's, from bodies that were looked at twice.

    An amount is read from many figures. What these have of the body they have in common, and their
    noise each for itself, so that of n figures with a share s the mean has

        n s / (1 + (n - 1) s)

    and an amount never less than its figures have by themselves.

    Args:
        first, again: amounts of each body in either look, (bodies, directions), 0 in the mean.
        by_figures: the share that the figures of each direction have, weighted as they show it.
    """
    count = len(first)
    common, both = (first * again).sum(axis=0), (first**2 + again**2).sum(axis=0) / 2
    found = common / np.maximum(both, 1e-300)
    drawn = (count * found + PAIRS * by_figures) / (count + PAIRS)
    return np.asarray(np.clip(drawn, by_figures, 1.0))
