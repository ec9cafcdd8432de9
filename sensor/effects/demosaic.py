"""Bilinear demosaicing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage, parameter
from sensor.neighbours import Runs
from sensor.planes import Planes
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Demosaic(Effect):
    """Fill in the two colours that a pixel does not see with the mean of its nearest neighbours.

    Measured samples pass unchanged; an interpolated one is the mean of 2 or 4, so its noise is
    1/sqrt(2) or 1/2 of the measured one: the paper's N_D. Borders are mirrored, which keeps the
    colour phase.

    A camera that counts in fractions rounds once, behind this. One that counts in whole numbers
    has rounded before, and rounds each mean again: then an interpolated sample is a function of
    whole neighbours, and every other mean of two is a half, so that it matters where halves go.
    One whose converter gives whole numbers but that counts in fractions from there on rounds again
    behind everything: without further processing that is the same as halves to the even number. One
    whose converter has four bits more than what leaves the camera counts in sixteenths, as cameras
    of 12 bits do that give 8: what processing makes of a sixteenth is a comb of its own.
    """

    name: ClassVar[str] = "demosaic"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 10
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equations (4) to (7)"

    arithmetic: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=5.0,
        whole=True,
        doc="0 in fractions; in whole numbers with halves 1 up, 2 to the even one, 3 down;"
        " 4 in fractions of whole samples, 5 of whole sixteenths",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        runs = Runs(signal)
        top, steps = float(signal.format.top_dn), STEPS[int(self.arithmetic)]
        above, here, below = (runs.line(dy) for dy in (-1, 0, 1))
        if steps is not None:
            above, here, below = (
                [dr.clip(dr.round(sample * steps) / steps, 0.0, top) for sample in line]
                for line in (above, here, below)
            )
        odd_row = (runs.row & 1) == 1
        sources = _sources(signal.format.cfa)
        colours: tuple[list[Any], ...] = ([], [], [])
        for k in range(runs.length):
            across, across_above, across_below = (
                (line[k] + line[k + 2]) * 0.5 for line in (here, above, below)
            )
            down = (above[k + 1] + below[k + 1]) * 0.5
            diagonal = (across_above + across_below) * 0.5
            means = (across, down, (across + down) * 0.5, diagonal)
            candidates = (here[k + 1], *map(WHOLE[int(self.arithmetic)], means))
            odd_column = runs.odd_column(k)
            for columns, by_phase in zip(colours, sources, strict=True):
                at = [candidates[source] for source in by_phase]
                even = dr.select(odd_column, at[1], at[0])
                columns.append(dr.select(odd_row, dr.select(odd_column, at[3], at[2]), even))
        return signal.replace(
            Planes(
                colours=tuple(tuple(columns) for columns in colours),
                shape=(*signal.shape, 3),
                arrays=signal.backend.arrays,
            )
        )


WHOLE: tuple[Callable[[Any], Any], ...] = (
    lambda mean: mean,
    lambda mean: dr.floor(mean + 0.5),
    dr.round,
    dr.floor,
    lambda mean: mean,
    lambda mean: mean,
)
"""What becomes of a mean, by arithmetic."""

STEPS = (None, 1.0, 1.0, 1.0, 1.0, 16.0)
"""Steps of the converter in a code that leaves the camera; None where it has endlessly many."""


def _sources(cfa: str) -> list[list[int]]:
    """For each colour and CFA phase, which candidate gives it.

    0 the sample itself, 1 mean of left and right, 2 of above and below, 3 of those four,
    4 of the diagonal four. Where all neighbours have the colour, 3 is taken.
    """
    grid = np.array(list(cfa)).reshape(2, 2)
    table = []
    for colour in "RGB":
        row = []
        for y, x in ((0, 0), (0, 1), (1, 0), (1, 1)):
            side, above, corner = grid[y, 1 - x], grid[1 - y, x], grid[1 - y, 1 - x]
            if grid[y, x] == colour:
                row.append(0)
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
