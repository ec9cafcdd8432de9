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
"""In fractions of a converter with endlessly many bits, rounded once behind everything."""

OF_WHOLE_SAMPLES = 4
"""In fractions behind a converter that has rounded: of itself it looks like halves to the even
number, and differs from it by what processing makes of the fractions."""

OF_SIXTEENTHS = 5
"""In fractions behind a converter with four more bits; the last halves go to the even number."""

OF_SIXTEENTHS_UP = 6
"""The same with the last halves up: in fractions of themselves these differ by a shift alone."""

OF_QUARTERS = 8
"""In fractions behind a converter with two more bits; the last halves go to the even number."""

OF_64THS = 11
"""The same with six more bits."""

WIDE = {OF_SIXTEENTHS: 1 / 16, OF_QUARTERS: 1 / 4}
TO_EVEN = {**WIDE, OF_64THS: 1 / 64}
"""Finer steps with the last halves to the even number, and by how much even codes are wider; of 64
so little that only twins can tell it from the picture's own unevenness."""

UP = {OF_SIXTEENTHS_UP: 1 / 32, 7: 1 / 32, 9: 1 / 8, 10: 1 / 8}
"""Finer steps with the last halves up, and by how much that raises all codes: they are equally
wide."""

FINER = (*TO_EVEN, *UP)

HALVES_TO_EVEN = 2
"""In whole numbers, the mean of two with its halves to the even number."""

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
        told: a rule that the images keep, or 0 where they keep none: it may be hidden by what was
            done to them afterwards.
    """
    if told == IN_FRACTIONS:
        # where halves go is lost in what hides the rule
        return (IN_FRACTIONS, *RULES, OF_WHOLE_SAMPLES, *WIDE)
    if told in TO_EVEN:
        return (told, IN_FRACTIONS)
    return (told, OF_WHOLE_SAMPLES) if told == HALVES_TO_EVEN else (told,)


def arithmetic_of(stacks: Sequence[NDArray[Any]], lattices: Sequence[Lattice]) -> int:
    """The arithmetic of a demosaicer, 0 (in fractions) where no rule in whole numbers holds.

    Without a demosaicer it is the converter's: in what steps of a code it counts.

    Args:
        stacks: frames of some shots, (n, H, W[, 3]).
        lattices: where the measured samples are.
    """
    if stacks[0].ndim != 4:
        return _by_width(stacks, lattices)
    if not of_a_mosaic(lattices):
        return IN_FRACTIONS
    pairs = [_means_of_two(inner(dn[:1])[0], one) for dn in stacks for one in lattices
             if one.channel != "G"]  # fmt: skip
    found = {
        name: np.mean([np.mean(rule(total) == mean) for total, mean in pairs])
        for name, rule in RULES.items()
    }
    best = max(found, key=lambda name: found[name])
    return best if found[best] > NEARLY_ALL else _by_width(stacks, lattices)


FRAMES = 16
"""Frames of a shot whose codes are counted."""

SMOOTH = np.array([0.25, 0.5, 0.25])
"""What even and odd codes have in common."""

LEAST_COUNT = 400
"""Samples of a code that count."""

LEAST_CODES = 20
"""Fewer codes have a shape of their own."""

LIKE = 0.25
"""Part of itself by which a width may be off."""

CLEAR = 6.0
"""Standard errors from which a width is no chance."""


def _by_width(stacks: Sequence[NDArray[Any]], lattices: Sequence[Lattice]) -> int:
    """Finer steps whose last halves go to the even code, by how much wider even codes are.

    Green alone is asked: a white balance makes combs of the others. Low codes and high ones have to
    agree, which those of a curve or of unequal steps do not.
    """
    off, size = np.zeros(2), np.zeros(2)
    asked = [lattice for lattice in lattices if lattice.channel in "GY"]
    for dn in stacks:
        greens = np.concatenate([one.of(dn[:FRAMES]).ravel() for one in asked])
        counts = np.bincount(greens).astype(np.float64)
        smooth = np.convolve(counts, SMOOTH, mode="same")
        often = np.flatnonzero(smooth[1:-1] > LEAST_COUNT) + 1
        if len(often) < LEAST_CODES:
            continue
        wider = (1.0 - 2.0 * (often % 2)) * (counts - smooth)[often]
        for half, at in enumerate(np.array_split(np.arange(len(often)), 2)):
            off[half] += wider[at].sum()
            size[half] += smooth[often][at].sum()
    for rule, wide in WIDE.items():
        alike = np.abs(off - wide * size) < LIKE * wide * size
        if alike.all() and (off > CLEAR * np.sqrt(size)).all():
            return rule
    return IN_FRACTIONS


def _means_of_two(frame: NDArray[Any], lattice: Lattice) -> tuple[Whole, Whole]:
    """Sums of neighbouring measured samples of a row, and what stands between them."""
    rows = frame[lattice.dy :: 2, :, "RGB".index(lattice.channel)].astype(np.int64)
    at = rows[:, lattice.dx :: 2]
    between = rows[:, lattice.dx + 1 :: 2]
    count = min(at.shape[1] - 1, between.shape[1])
    return at[:, :count] + at[:, 1 : count + 1], between[:, :count]
