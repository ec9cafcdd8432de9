"""Bilinear demosaicing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sensor.effect import Effect, Stage
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
        import drjit as dr

        f, height, width = signal.shape
        flat = signal.value.array
        dr.eval(flat)
        frame, y, x = signal.coordinates()
        start = frame * (height * width)

        def neighbour(dy: int, dx: int) -> Any:
            row, column = mirrored(y, dy, height), mirrored(x, dx, width)
            return dr.gather(type(flat), flat, start + row * width + column)

        centre = neighbour(0, 0)
        across = (neighbour(0, -1) + neighbour(0, 1)) * 0.5
        down = (neighbour(-1, 0) + neighbour(1, 0)) * 0.5
        diagonal = (
            neighbour(-1, -1) + neighbour(-1, 1) + neighbour(1, -1) + neighbour(1, 1)
        ) * 0.25
        candidates = (centre, across, down, (across + down) * 0.5, diagonal)

        out = dr.empty(type(flat), 3 * dr.width(flat))
        at = dr.arange(type(y), dr.width(flat)) * 3
        phase = (y & 1) * 2 + (x & 1)
        for colour, sources in enumerate(_sources(signal.format.cfa)):
            value = candidates[sources[0]]
            for k in (1, 2, 3):
                value = dr.select(phase == k, candidates[sources[k]], value)
            dr.scatter(out, value, at + colour)
        return signal.replace(type(signal.value)(out, (f, height, width, 3)))


def mirrored(index: Any, shift: int, length: int) -> Any:
    """Shift indices by -1, 0 or 1 and reflect those that leave about the first or last sample."""
    import drjit as dr

    if shift == 0:
        return index
    if shift < 0:
        return dr.select(index == 0, 1, index - 1)
    return dr.select(index == length - 1, length - 2, index + 1)


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
