"""Three colours in every pixel of a mosaic: the mean of the nearest samples that have the colour.

Borders are mirrored about the outermost samples, which keeps the colour phase, so that a picture
mirrored in this way is what the mirrored mosaic gives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np

from sensor.neighbours import Runs
from sensor.planes import Planes
from sensor.signal import Signal


@dataclass(frozen=True, kw_only=True)
class Counting:
    """How a camera counts when it fills in colours.

    Attributes:
        steps: of the converter in a code that leaves the camera; None where it has endlessly many.
        whole: what becomes of a mean, counted in these steps; None where it stays a fraction.
        up: whether the last rounding, behind everything, sends halves up; else to the even code.
    """

    steps: float | None = None
    whole: Callable[[Any], Any] | None = None
    up: bool = False

    def of_sample(self, sample: Any, top_dn: float) -> Any:
        """What the converter makes of a sample."""
        if self.steps is None:
            return sample
        return dr.clip(dr.round(sample * self.steps) / self.steps, 0.0, top_dn)

    def of_mean(self, mean: Any) -> Any:
        """What becomes of a mean of two or four samples."""
        if self.whole is None or self.steps is None:
            return mean
        return self.whole(mean * self.steps) / self.steps

    def at_last(self, value: Any) -> Any:
        """The value, so that the last rounding sends halves where this camera does."""
        if not self.up or self.steps is None:
            return value
        return value + UPWARDS


UPWARDS = 2.0**-14
"""Of a code: takes halves up and nothing else, as a mean of four has steps of 1/64 and more, and
numbers of 32 bits below 256 have finer ones."""


def _halves_up(mean: Any) -> Any:
    return dr.floor(mean + 0.5)


COUNTING = (
    Counting(),
    Counting(steps=1.0, whole=_halves_up),
    Counting(steps=1.0, whole=dr.round),
    Counting(steps=1.0, whole=dr.floor),
    Counting(steps=1.0),
    Counting(steps=16.0),
    Counting(steps=16.0, up=True),
    Counting(steps=16.0, whole=_halves_up, up=True),
    Counting(steps=4.0),
    Counting(steps=4.0, up=True),
    Counting(steps=4.0, whole=_halves_up, up=True),
    Counting(steps=64.0),
)
"""By the arithmetic of `sensor.effects.demosaic`."""

Row = tuple[list[Any], list[Any], list[Any]]
"""Columns of red, green and blue."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Interpolated:
    """What a demosaicer makes of a mosaic, made anew wherever somebody looks.

    With a JIT backend that is faster than to write three colours and to read them again.

    Attributes:
        mosaic: one value a pixel.
        arithmetic: how it counts, as `sensor.effects.demosaic` tells.
        corners: whether a measured green is averaged with those at its corners.
    """

    mosaic: Signal
    arithmetic: int = 0
    corners: bool = False

    @property
    def linear(self) -> bool:
        """Whether a sum of such pictures is what the sum of the mosaics gives."""
        return self.arithmetic == 0

    def signal(self) -> Signal:
        """The picture, which knows what it was made of."""
        (colours,) = self.rows(0)
        made = Planes(
            colours=tuple(tuple(columns) for columns in colours),
            shape=(*self.mosaic.shape, 3),
            arrays=self.mosaic.backend.arrays,
        )
        return self.mosaic.replace(made, interpolated=self if self.mosaic.backend.jit else None)

    def rows(self, reach: int) -> list[Row]:
        """Rows from so many above each run to so many below, from so many columns left of it on."""
        runs = Runs(self.mosaic)
        lines = [self._samples(runs.line(dy, reach + 1)) for dy in range(-reach - 1, reach + 2)]
        return [
            self._row(runs, lines[at - 1 : at + 2], at - 1 - reach)
            for at in range(1, 2 * reach + 2)
        ]

    def _samples(self, line: list[Any]) -> list[Any]:
        counting, top_dn = COUNTING[self.arithmetic], float(self.mosaic.format.top_dn)
        return [counting.of_sample(sample, top_dn) for sample in line]

    def _row(self, runs: Runs, lines: list[list[Any]], dy: int) -> Row:
        """Colours of the row dy below, from its samples and those above and below it."""
        above, here, below = lines
        odd_row = ((runs.places.row + (dy & 1)) & 1) == 1
        counting = COUNTING[self.arithmetic]
        sources = _sources(self.mosaic.format.cfa, self.corners)
        colours: Row = ([], [], [])
        for k in range(len(here) - 2):
            across, across_above, across_below = (
                (line[k] + line[k + 2]) * 0.5 for line in (here, above, below)
            )
            down = (above[k + 1] + below[k + 1]) * 0.5
            diagonal = (across_above + across_below) * 0.5
            means = [across, down, (across + down) * 0.5, diagonal]
            if self.corners:
                means.append((here[k + 1] + diagonal) * 0.5)
            candidates = [
                counting.at_last(one) for one in (here[k + 1], *map(counting.of_mean, means))
            ]
            odd_column = runs.places.odd_column(k - (len(here) - 2 - runs.length) // 2)
            for columns, by_phase in zip(colours, sources, strict=True):
                at = [candidates[source] for source in by_phase]
                even = dr.select(odd_column, at[1], at[0])
                columns.append(dr.select(odd_row, dr.select(odd_column, at[3], at[2]), even))
        return colours


def _sources(cfa: str, corners: bool) -> list[list[int]]:
    """For each colour and CFA phase, which candidate gives it.

    0 the sample itself, 1 mean of left and right, 2 of above and below, 3 of those four,
    4 of the diagonal four, 5 of those and the sample, where corners count. Where all neighbours
    have the colour, 3 is taken.
    """
    grid = np.array(list(cfa)).reshape(2, 2)
    table = []
    for colour in "RGB":
        row = []
        for y, x in ((0, 0), (0, 1), (1, 0), (1, 1)):
            side, above, corner = grid[y, 1 - x], grid[1 - y, x], grid[1 - y, 1 - x]
            if grid[y, x] == colour:
                row.append(5 if corners and corner == colour != side else 0)
            elif side == colour and above == colour:
                row.append(3)
            elif side == colour:
                row.append(1)
            elif above == colour:
                row.append(2)
            else:
                row.append(4 if corner == colour else 0)
        table.append(row)
    return table
