"""Blooming."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Blooming(Effect):
    """A full photosite spills into those above and below it; channel stops shut off the sides.

    Of the charge above full well the anti-blooming drain takes its share; half of the rest runs
    down the column and half up. Running charge fills whatever room it meets,

        carry_y = max(carry_(y-1) + spill_y - room_y, 0),

    that is S_y - min(0, min S) with S the running sum of spill - room. What reaches the end of the
    column is lost.

    Consequence: without a drain every column keeps its charge; trails stand at full well exactly,
    equally long up and down, and no column beside the light changes. A blur crosses columns, and
    clipping loses charge.
    """

    name: ClassVar[str] = "blooming"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 70
    reference: ClassVar[str] = (
        "Janesick, Scientific Charge-Coupled Devices, SPIE 2001, chapter on full well and blooming"
    )

    full_well_e: float = parameter(
        14_000.0,
        unit="e-",
        minimum=500.0,
        maximum=1e7,
        identity=1e7,
        doc="charge that a photosite holds; 14 to 20 ke- by area from related sensors",
    )
    drained: float = parameter(
        0.8,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        doc="share of the charge above full well that the anti-blooming drain takes",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        charge = signal.value.array
        dr.eval(charge)
        excess = dr.maximum(charge - self.full_well_e, 0.0)
        if not dr.any(excess > 0.0):
            return signal.replace(+signal.value)
        columns = Columns(signal)
        spill = columns.of(excess * ((1.0 - self.drained) / 2))
        held = columns.of(charge - excess)
        held = held + poured(spill, self.full_well_e - held, columns.height, upwards=False)
        held = held + poured(spill, self.full_well_e - held, columns.height, upwards=True)
        return signal.replace(type(signal.value)(columns.back(held), signal.shape))


def poured(spill: Any, room: Any, height: int, *, upwards: bool) -> Any:
    """Charge that stays in each pixel when the spills run along their columns; flat.

    Args:
        spill, room: charge that leaves a pixel, and that it can take; column by column.
        height: length of a column.
        upwards: whether it runs towards row 0.
    """
    # sums over a column reach millions of e-: double precision keeps them to a thousandth of one
    double: Any = dr.float64_array_t(type(spill))
    step = double(spill) - double(room)
    total = dr.block_prefix_reduce(dr.ReduceOp.Add, step, height, False, upwards)
    carried = type(spill)(total - dr.minimum(running_minimum(total, height, upwards), 0.0))
    dr.eval(carried)
    lane = dr.arange(dr.uint32_array_t(type(spill)), dr.width(spill))
    place = lane % height
    starts = place == (height - 1 if upwards else 0)
    before = dr.select(starts, lane, lane + 1 if upwards else lane - 1)
    arriving = dr.select(starts, 0.0, dr.gather(type(spill), carried, before)) + spill
    return dr.minimum(arriving, room)


def running_minimum(values: Any, height: int, upwards: bool) -> Any:
    """The least value of a column so far, from the top or from the bottom; flat."""
    if dr.is_jit_v(values):
        return dr.block_prefix_reduce(dr.ReduceOp.Min, values, height, False, upwards)
    # Dr.Jit 1.5.0 multiplies where it should compare, on its scalar arrays alone
    columns = np.asarray(values.numpy()).reshape(-1, height)
    towards = slice(None, None, -1 if upwards else 1)
    least = np.minimum.accumulate(columns[:, towards], axis=1)[:, towards]
    return type(values)(np.ascontiguousarray(least).ravel())


class Columns:
    """The same numbers with the pixels of a column side by side in memory, and back again."""

    def __init__(self, signal: Signal) -> None:
        frames, self.height, self.width = signal.shape
        index = dr.uint32_array_t(type(signal.value.array))
        self.lane = dr.arange(index, frames * self.height * self.width)

    def of(self, rows: Any) -> Any:
        """From row by row to column by column."""
        return self._turned(rows, self.height, self.width)

    def back(self, columns: Any) -> Any:
        """From column by column to row by row."""
        return self._turned(columns, self.width, self.height)

    def _turned(self, flat: Any, height: int, width: int) -> Any:
        """Transpose each frame of `height` lines of `width` numbers."""
        dr.eval(flat)
        frame = self.lane // (height * width)
        at = self.lane - frame * (height * width)
        column = at // height
        row = at - column * height
        return dr.gather(type(flat), flat, frame * (height * width) + row * width + column)
