"""Column fixed-pattern noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ColumnFpn(Effect):
    """Every column has an offset of its own, the same in all rows, all frames and at all levels.

        e(k, y, x) += sigma n(x),    n standard normal, drawn once for the camera body

    Amplifiers or converters by column make it in CMOS sensors, clock feed-through and traps of the
    vertical register in a CCD. Adds sigma^2 to the variance of the mean of a column however high
    the column is, where offsets of single pixels with the same variance add sigma^2 / H; no
    temporal noise.
    """

    name: ClassVar[str] = "column_fpn"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 12
    reference: ClassVar[str] = (
        "sigma_h of the 3-D noise model: D'Agostino and Webb, SPIE 1488, 110 (1991); "
        "EMVA 1288 release 4, column DSNU"
    )

    sigma_e: float = parameter(
        8.0,
        unit="e-",
        minimum=0.0,
        maximum=1000.0,
        identity=0.0,
        doc="standard deviation of the offsets over the columns",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        offset = stream.body.normal(1, signal.shape[2])
        return signal.replace(signal.value + signal.by_colour(self.sigma_e) * offset)
