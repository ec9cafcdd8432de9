"""How a camera counts when it fills in colours: told by samples that are means of two others.

A demosaicer in whole numbers gives (a + b) / 2 of two measured samples exactly, but for where it
sends halves; one in fractions, rounded once behind, differs by one now and then, because a and b
were rounded as well. Anything that changes pixels afterwards hides the difference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice, inner, of_a_mosaic

Whole = NDArray[np.int64]

IN_FRACTIONS = 0
OF_WHOLE_SAMPLES = 4
"""In fractions behind a converter that has rounded: of itself it looks like halves to the even
number, and differs from it by what processing makes of the fractions."""

OF_SIXTEENTHS = 5
"""In fractions behind a converter with four more bits; the last halves go to the even number."""

OF_SIXTEENTHS_UP = 6
"""The same with the last halves up: in fractions of themselves these differ by a shift alone."""

IN_SIXTEENTHS = (OF_SIXTEENTHS, OF_SIXTEENTHS_UP)

HALVES_TO_EVEN = 2

RULES: dict[int, Callable[[Whole], Whole]] = {
    1: lambda total: (total + 1) // 2,
    HALVES_TO_EVEN: lambda total: total // 2 + (total & total // 2 & 1),
    3: lambda total: total // 2,
}
"""A mean of two whole numbers from their sum, by the arithmetic of `sensor.effects.demosaic`."""

NEARLY_ALL = 0.98
"""Share of the samples that follow a rule which the camera has."""


def rules_of(told: int) -> tuple[int, ...]:
    """The ways of counting that colour images leave open, by what `arithmetic_of` tells.

    Args:
        told: a rule in whole numbers that the images keep, or 0 where they keep none: it may be
            hidden by what was done to them afterwards.
    """
    if told == IN_FRACTIONS:
        return (IN_FRACTIONS, *RULES, OF_WHOLE_SAMPLES, OF_SIXTEENTHS)
    return (told, OF_WHOLE_SAMPLES) if told == HALVES_TO_EVEN else (told,)


def arithmetic_of(stacks: Sequence[NDArray[Any]], lattices: Sequence[Lattice]) -> int:
    """The arithmetic of a demosaicer, 0 (in fractions) where no rule in whole numbers holds.

    Args:
        stacks: frames of some shots, (n, H, W, 3); others have no demosaicer to ask.
        lattices: where the measured samples are.
    """
    if not of_a_mosaic(lattices) or any(dn.ndim != 4 for dn in stacks):
        return IN_FRACTIONS
    pairs = [_means_of_two(inner(dn[:1])[0], one) for dn in stacks for one in lattices
             if one.channel != "G"]  # fmt: skip
    found = {
        name: np.mean([np.mean(rule(total) == mean) for total, mean in pairs])
        for name, rule in RULES.items()
    }
    best = max(found, key=lambda name: found[name])
    return best if found[best] > NEARLY_ALL else IN_FRACTIONS


def _means_of_two(frame: NDArray[Any], lattice: Lattice) -> tuple[Whole, Whole]:
    """Sums of neighbouring measured samples of a row, and what stands between them."""
    rows = frame[lattice.dy :: 2, :, "RGB".index(lattice.channel)].astype(np.int64)
    at = rows[:, lattice.dx :: 2]
    between = rows[:, lattice.dx + 1 :: 2]
    count = min(at.shape[1] - 1, between.shape[1])
    return at[:, :count] + at[:, 1 : count + 1], between[:, :count]
