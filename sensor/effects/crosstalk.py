"""Crosstalk between photosites."""

from __future__ import annotations

import operator
from dataclasses import dataclass
from typing import Any, ClassVar

from sensor.charge_flow import AROUND, BESIDE, after_exchange
from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Crosstalk(Effect):
    """Light and charge born under one photosite are collected by those around it.

        mean' = mean + sum over the neighbours of a (f_neighbour neighbour - f mean),
        a = s (1 - c) h / 2 in the row, s (1 - c) (1 - h) / 2 in the column, s c / 4 at the corners

    with s the share that leaves, c the part of it that goes to the corners, and h the part of the
    rest that leaves along the rows: a photosite between vertical registers is no square. Red light
    frees its charge deeper, from where it spreads farther: f is 1 + d under a red filter, 1 under
    a green one and 1 - d under a blue one.
    Nothing crosses the border of the sensor, and nothing is lost.

    Consequence: every electron picks its photosite by itself, so the counts stay independent
    Poisson numbers: an edge is smeared by a to each side while the noise keeps variance =
    mean and no correlation. A blur of finished frames correlates the noise.
    """

    name: ClassVar[str] = "crosstalk"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "Janesick, Scientific Charge-Coupled Devices, SPIE 2001, charge diffusion; "
        "Blockstein and Yadid-Pecht, Crosstalk quantification, analysis, and trends in CMOS image "
        "sensors, Applied Optics 49, 2010"
    )

    share: float = parameter(
        0.06,
        unit="1",
        minimum=0.0,
        maximum=0.8,
        identity=0.0,
        doc="share of a photosite's charge that its neighbours collect",
    )
    along_rows: float = parameter(
        0.5,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        doc="part that goes to the two of the same row, of what does not go to corners",
    )
    to_corners: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=0.25,
        doc="part that goes to the four at the corners: a third of what a side gets at most, as a "
        "corner is farther away",
    )

    deeper_in_red: float = parameter(
        0.0,
        unit="1",
        minimum=-0.9,
        maximum=0.9,
        doc="by what part more of it leaves under a red filter than under a green one, and less "
        "under a blue one",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        corner = self.share * self.to_corners / 4
        straight = self.share * (1 - self.to_corners)
        row, column = straight * self.along_rows / 2, straight * (1 - self.along_rows) / 2

        def inflow(own: Any, beside: Any, dy: int, dx: int) -> Any:
            part = corner if dy and dx else column if dy else row
            return part * (beside - own)

        d = self.deeper_in_red
        free = signal.pointwise(operator.mul, Colours(R=1 + d, G=1.0, B=1 - d)) if d else None
        neighbours = AROUND if corner else BESIDE
        return signal.replace(after_exchange(signal, inflow, neighbours, free))
