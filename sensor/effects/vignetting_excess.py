"""Vignetting beyond the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant, from_centre_px, half_diagonal_px
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class VignettingExcess(Effect):
    """The lens darkens the corners more (or less) than the model of it does.

        rate' = rate (1 - k2 r^2 - k4 r^4),    r = 1 in the corners

    The same in all colours, frames and lamps: rings about the centre are even, and fall along the
    polynomial. Pixel gains of equal variance are as large inside a ring as between rings; a
    displaced lamp is not symmetric.
    """

    name: ClassVar[str] = "vignetting_excess"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 50
    reference: ClassVar[str] = "Goldman, IEEE TPAMI 32, 2276 (2010), even polynomial in r"

    k2: float = parameter(
        0.05, unit="1", minimum=-0.4, maximum=0.4, identity=0.0, doc="loss in the corner as r^2"
    )
    k4: float = parameter(
        0.05, unit="1", minimum=-0.4, maximum=0.4, identity=0.0, doc="loss in the corner as r^4"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        down, right = from_centre_px(signal)
        scale, k2, k4 = (
            constant(signal, figure)
            for figure in (1.0 / half_diagonal_px(signal.format), self.k2, self.k4)
        )
        y, x = down * scale, right * scale
        r2 = y * y + x * x
        return signal.replace(signal.value * (1.0 - r2 * (k2 + r2 * k4)))
