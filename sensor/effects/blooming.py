"""Blooming."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Blooming(Effect):
    """A full photosite spills into those above and below it; channel stops shut off the sides.

    Of the charge above full well the anti-blooming drain takes its share; half of the rest runs
    down the column and half up. Running charge fills whatever room it meets, and of what runs on
    through a full photosite the drain takes some again,

        carry_y = exp(-1 / L) max(carry_(y-1) - room_y, 0) + spill_y,

    first down, then up into the room that is left. What reaches the end of the column is lost.

    Consequence: without a drain every column keeps its charge; trails stand at full well exactly,
    equally long up and down, and no column beside the light changes. A blur crosses columns, and
    clipping loses charge. With one, h full rows that spill s each give (1 - r^h) / (1 - r) s away
    at each end, r = exp(-1 / L): a large patch no more than one of some L rows.
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
        starts=(0.8, 0.0),
        doc="share of the charge above full well that the anti-blooming drain takes",
    )

    reach_rows: float = parameter(
        1e6,
        unit="rows",
        minimum=0.5,
        maximum=1e6,
        starts=(1e6, 5.0),
        doc="rows in which running charge falls to 1/e where the drain takes of it on the way",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        charge = signal.value.array
        dr.eval(charge)
        if not dr.any(charge > self.full_well_e):
            return signal.replace(+signal.value)
        held = dr.minimum(charge, self.full_well_e)
        for upwards in (False, True):
            held = self.poured(charge, held, signal.shape, upwards=upwards)
        return signal.replace(type(signal.value)(held, signal.shape))

    def poured(self, charge: Any, held: Any, shape: tuple[int, ...], *, upwards: bool) -> Any:
        """What the pixels hold after the spills have run along their columns one way; flat.

        Args:
            charge: what was collected, from which the spills come.
            held: what the pixels hold before.
            shape: (f, H, W).
            upwards: whether it runs towards row 0.
        """
        frames, height, width = shape
        flat, index = type(charge), dr.uint32_array_t(type(charge))
        dr.eval(held)
        out = dr.empty(flat, dr.width(charge))
        lane = dr.arange(index, frames * width)
        frame = lane // width
        column = lane + frame * (width * (height - 1))
        share, passing = (1.0 - self.drained) / 2, math.exp(-1.0 / self.reach_rows)

        def go_on(y: Any, carry: Any) -> Any:
            return y < height

        def step(y: Any, carry: Any) -> tuple[Any, Any]:
            at = column + (height - 1 - y if upwards else y) * width
            before = dr.gather(flat, held, at)
            spilt = share * dr.maximum(dr.gather(flat, charge, at) - self.full_well_e, 0.0)
            kept = dr.minimum(carry, self.full_well_e - before)
            dr.scatter(out, before + kept, at)
            return y + 1, passing * (carry - kept) + spilt

        # one lane a column; without a compiler the rows are counted in Python
        first = dr.zeros(index, dr.width(lane)) if dr.is_jit_v(flat) else 0
        dr.while_loop((first, dr.zeros(flat, dr.width(lane))), go_on, step, labels=("y", "carry"))
        return out
