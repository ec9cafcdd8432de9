"""Offset fixed-pattern noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Fpn(Effect):
    """Every photosite has its own offset, the same in all frames and at all light levels.

    The pattern belongs to the camera body. Spatial standard deviation sigma_e; no temporal noise.
    """

    name: ClassVar[str] = "fpn"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 10
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equation (1) and Table I; DSNU in EMVA 1288 release 4"

    sigma_e: float | Colours = parameter(
        5.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        per_colour=True,
        doc="standard deviation of the offsets over the photosites",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        pattern = stream.body.normal(*signal.shape[1:])
        return signal.pointwise(lambda e, sigma, n: e + sigma * n, self.sigma_e, pattern)
