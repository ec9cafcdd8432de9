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

    mean' = mean + (s / 4) sum over the neighbours of (neighbour - mean), s the share that leaves.
    Nothing crosses the border of the sensor, and nothing is lost.

    Consequence: every electron picks its photosite by itself, so the counts stay independent
    Poisson numbers: an edge is smeared by s / 4 to each side while the noise keeps variance =
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

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        each = self.share / 4
        return signal.replace(after_exchange(signal, lambda own, beside, _: each * (beside - own)))
