"""Photo-response non-uniformity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Prnu(Effect):
    """Every photosite collects its own share of the light: I (1 + p n), n standard normal.

    The pattern belongs to the camera body. Spatial standard deviation p I; no effect in the dark.
    """

    name: ClassVar[str] = "prnu"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 20
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equation (1) and Table II; EMVA 1288 release 4, 8.2"

    ratio: float | Colours = parameter(
        0.01,
        unit="1",
        minimum=0.0,
        maximum=0.2,
        identity=0.0,
        per_colour=True,
        doc="standard deviation of the response, relative to its mean",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        pattern = stream.body.normal(*signal.shape[1:])
        ratio = Colours.of(self.ratio)
        return signal.pointwise(lambda mean, p, n: mean * (1.0 + p * n), ratio, pattern)
