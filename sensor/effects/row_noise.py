"""Row noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class RowNoise(Effect):
    """All pixels of a row are read with one reference, and its error is theirs together.

        e(k, y, x) += sigma n(k, y),    n standard normal, drawn for every row of every frame

    The clamp that sets black at the start of each row samples noise of its own; a supply that
    moves between rows does the same. Adds sigma^2 to the temporal variance of a pixel, and sigma^2
    to the variance of the mean of a row however wide the row is, where independent noise of the
    same variance adds sigma^2 / W.
    """

    name: ClassVar[str] = "row_noise"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 30
    reference: ClassVar[str] = (
        "sigma_tv of the 3-D noise model: D'Agostino and Webb, SPIE 1488, 110 (1991)"
    )

    sigma_e: float = parameter(
        6.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        doc="standard deviation of the offset of a row from frame to frame",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        offset = stream.normal(signal.shape[1], 1)
        return signal.replace(signal.value + signal.by_colour(self.sigma_e) * offset)
