"""Response that varies slowly over the sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class LargeScalePrnu(Effect):
    """Rings of uneven doping in the silicon, thinner response at the edges of the chip, and slow
    waves of no order, as uneven layers over the chip leave them.

    mean' = mean [1 + sqrt(2) p cos(2 pi r / period + phase)] (1 - e exp(-d / 15 px)) (1 + f w),
    r the distance from a centre of growth outside the chip, d the distance from the nearest edge,
    w = sqrt(2 / n) sum of cos(k . x + phase) over n waves with k normal, of 1 / length along each
    axis. Centre, waves and phases belong to the camera body.

    Consequence: the pattern scales with the light. Along the rings' radius it repeats: pixels a
    distance s apart correlate as cos(2 pi s / period); those of the waves as
    exp(-s^2 / (2 length^2)). Independent PRNU of equal variance does not correlate at all.
    """

    name: ClassVar[str] = "large_scale_prnu"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 18
    reference: ClassVar[str] = (
        "Plazas, Bernstein and Sheldon, On-sky measurements of the transverse electric fields' "
        "effects in the Dark Energy Camera CCDs, PASP 126, 2014: tree rings and glowing edges"
    )

    ring_ratio: float = parameter(
        0.01,
        unit="1",
        minimum=0.0,
        maximum=0.1,
        identity=0.0,
        doc="standard deviation of the rings, relative to the mean response",
    )
    ring_period_px: float = parameter(
        40.0,
        unit="px",
        minimum=8.0,
        maximum=1000.0,
        doc="distance from ring to ring",
    )
    edge_ratio: float = parameter(
        0.03,
        unit="1",
        minimum=-0.5,
        maximum=0.5,
        identity=0.0,
        doc="loss of response at the very edge, dying out over 15 px",
    )
    field_ratio: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=0.1,
        identity=0.0,
        doc="standard deviation of the waves, relative to the mean response",
    )
    field_length_px: float = parameter(
        30.0,
        unit="px",
        minimum=4.0,
        maximum=1000.0,
        doc="distance over which the waves are alike",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        still = signal.replace(signal.value[:1])
        response = self.rings(still, stream) * self.edges(still)
        if self.field_ratio != 0:
            response = response * self.field(still, stream)
        return signal.replace(signal.value * type(signal.value)(response, still.shape))

    def rings(self, still: Signal, stream: Stream) -> Any:
        """Response of the rings at every pixel, flat."""
        flat = type(still.value.array)
        _, height, width = still.shape
        _, row, column = still.coordinates()
        drawn = stream.body.uniform(2).array
        zero = dr.zeros(dr.uint32_array_t(flat), 1)
        direction = 2 * math.pi * dr.gather(flat, drawn, zero)
        phase = 2 * math.pi * dr.gather(flat, drawn, zero + 1)
        far = 1.5 * math.hypot(height, width)
        y = flat(row) - (height / 2 + far * dr.sin(direction))
        x = flat(column) - (width / 2 + far * dr.cos(direction))
        turn = dr.sqrt(x * x + y * y) * (2 * math.pi / self.ring_period_px)
        return 1.0 + math.sqrt(2) * self.ring_ratio * dr.cos(turn + phase)

    def field(self, still: Signal, stream: Stream) -> Any:
        """Response of the waves at every pixel, flat."""
        flat = type(still.value.array)
        index = dr.uint32_array_t(flat)
        _, row, column = still.coordinates()
        number = dr.opaque(flat, 1.0 / self.field_length_px)
        down = stream.body.normal(WAVES, use="down").array * number
        right = stream.body.normal(WAVES, use="right").array * number
        phase = stream.body.uniform(WAVES, use="wave").array * (2 * math.pi)
        dr.eval(down, right, phase)
        y, x = flat(row), flat(column)

        def step(wave: Any, total: Any) -> tuple[Any, Any]:
            ky, kx, begin = (dr.gather(flat, one, index(wave)) for one in (down, right, phase))
            return wave + 1, total + dr.cos(ky * y + kx * x + begin)

        start = (still.backend.arrays.UInt32(0), dr.zeros(flat, dr.width(y)))
        _, total = dr.while_loop(
            start, lambda wave, total: wave < WAVES, step, labels=("wave", "total")
        )
        return 1.0 + dr.opaque(flat, self.field_ratio * math.sqrt(2.0 / WAVES)) * total

    def edges(self, still: Signal) -> Any:
        """Response towards the edges at every pixel, flat."""
        flat = type(still.value.array)
        _, height, width = still.shape
        _, row, column = still.coordinates()
        y, x = flat(row), flat(column)
        inwards = dr.minimum(dr.minimum(y, height - 1 - y), dr.minimum(x, width - 1 - x))
        return 1.0 - self.edge_ratio * dr.exp(-inwards / EDGE_PX)


WAVES = 32
"""Enough that their sum is nearly normal."""

EDGE_PX = 15.0
"""How far the edge reaches into the chip: an assumption, for lack of a figure for such a die."""
