"""The brighter-fatter effect."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from sensor.charge_flow import after_exchange
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class BrighterFatter(Effect):
    """Collected charge repels charge that is still coming, and so moves the pixel's boundaries.

    Between two neighbours 1 and 2 the boundary moves by a (Q1 - Q2) / 2 of a pixel in the mean of
    the exposure, and sweeps the charge that lies there: Q2 gains a (Q1 - Q2)(Q1 + Q2) / 4 and Q1
    loses it. Only the four nearest boundaries move; none at the border of the sensor.

    Consequence: for even light of mean m and with s = a m / 2 the covariance with each nearest
    neighbour is 2 s (1 - 4 s) m, nearly a m^2 - it grows with the square of the mean - and the
    variance is m [(1 - 4 s)^2 + 4 s^2], so that variance and covariances together stay m. A blur
    of finished frames has covariances in proportion to the mean, independent noise has none.
    """

    name: ClassVar[str] = "brighter_fatter"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 60
    reference: ClassVar[str] = (
        "Antilogus et al., The brighter-fatter effect and pixel correlations in CCD sensors, "
        "JINST 9 C03048, 2014; Guyonnet et al., A&A 575 A41, 2015"
    )

    horizontal_per_e: float = parameter(
        2e-6,
        unit="1/e-",
        minimum=0.0,
        maximum=1e-5,
        identity=0.0,
        doc="covariance with the neighbour in the row, over the square of the mean",
    )
    vertical_per_e: float = parameter(
        3e-6,
        unit="1/e-",
        minimum=0.0,
        maximum=1e-5,
        identity=0.0,
        doc="covariance with the neighbour in the column, over the square of the mean",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        def inflow(own: Any, beside: Any, dy: int, dx: int) -> Any:
            a = self.vertical_per_e if dy else self.horizontal_per_e
            return (a / 4) * ((beside - own) * (beside + own))

        return signal.replace(after_exchange(signal, inflow))
