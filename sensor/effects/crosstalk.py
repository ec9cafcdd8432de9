"""Crosstalk between photosites."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.charge_flow import after_exchange
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Crosstalk(Effect):
    """Light and charge born under one photosite are collected by the four beside it.

    mean' = mean + sum over the neighbours of a (neighbour - mean), with a = s h / 2 for the two of
    the same row and s (1 - h) / 2 for those of the same column, s the share that leaves and h the
    part of it that leaves along the rows: a photosite between vertical registers is no square.
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
        doc="share of a photosite's charge that its four neighbours collect",
    )
    along_rows: float = parameter(
        0.5,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        doc="part of it that goes to the two of the same row",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        row, column = self.share * self.along_rows / 2, self.share * (1 - self.along_rows) / 2
        return signal.replace(
            after_exchange(signal, lambda own, beside, dy: (column if dy else row) * (beside - own))
        )
