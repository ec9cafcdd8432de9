"""Bilinear demosaicing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage
from sensor.neighbours import Neighbours
from sensor.planes import Planes
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Demosaic(Effect):
    """Fill in the two colours that a pixel does not see with the mean of its nearest neighbours.

    Measured samples pass unchanged; an interpolated one is the mean of 2 or 4, so its noise is
    1/sqrt(2) or 1/2 of the measured one: the paper's N_D. Borders are mirrored, which keeps the
    colour phase.
    """

    name: ClassVar[str] = "demosaic"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 10
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equations (4) to (7)"

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        beside = Neighbours(signal)
        centre = beside.flat
        across = (beside.flat_at(0, -1) + beside.flat_at(0, 1)) * 0.5
        down = (beside.flat_at(-1, 0) + beside.flat_at(1, 0)) * 0.5
        # the mean of the four diagonal ones is the mean of what lies across, above and below
        above = Neighbours(signal.replace(beside.tensor(across, signal.shape)))
        diagonal = (above.flat_at(-1, 0) + above.flat_at(1, 0)) * 0.5
        candidates = (centre, across, down, (across + down) * 0.5, diagonal)

        phase = (beside.row & 1) * 2 + (beside.column & 1)
        colours = []
        for sources in _sources(signal.format.cfa):
            plane = candidates[sources[0]]
            for k in (1, 2, 3):
                plane = dr.select(phase == k, candidates[sources[k]], plane)
            colours.append(plane)
        red, green, blue = colours
        f, height, width = signal.shape
        return signal.replace(
            Planes(colours=(red, green, blue), shape=(f, height, width, 3), kind=beside.tensor)
        )


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
