"""Sharpening."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.errors import CameraError
from sensor.luma import luma
from sensor.neighbours import Neighbours
from sensor.signal import Signal
from sensor.stream import Stream

_SOFT = {(dy, dx): (2 - abs(dy)) * (2 - abs(dx)) / 16 for dy in (-1, 0, 1) for dx in (-1, 0, 1)}
"""The binomial kernel 1-2-1 by 1-2-1."""


@dataclass(frozen=True, kw_only=True)
class Sharpening(Effect):
    """Unsharp masking: what a soft copy lacks is added once more.

        DN'_c = DN_c + a (Y - Y * B),    B = (1 2 1)^T (1 2 1) / 16

    Y is luma, as in video, and the pixel itself in a camera without colours. Means of flat areas
    stay. White noise of variance v gets the covariance v (h correlated with itself) for
    h = (1 + a) delta - a B: v (1 + 3a/2 + 41a^2/64) at lag 0 and negative at the nearest lags,
    at every light level alike; independent noise of the same variance has none there.
    """

    name: ClassVar[str] = "sharpening"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 60
    reference: ClassVar[str] = (
        "Rosenfeld and Kak, Digital Picture Processing (1982), chapter 6: unsharp masking"
    )

    amount: float = parameter(
        0.5,
        unit="1",
        minimum=0.0,
        maximum=5.0,
        identity=0.0,
        doc="how much of the detail is added",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.coloured:
            grey = signal.replace(luma(signal, self.name))
        elif len(set(signal.format.cfa)) == 1:
            grey = signal
        else:
            raise CameraError(
                "effect 'sharpening' on a mosaic",
                "expected three colours in every pixel, or a camera without colour filters",
                "add the effect 'demosaic' (with pixels rgb8), or remove this one",
            )
        detail = grey.value - Neighbours(grey).weighted(_SOFT)
        if signal.coloured:
            detail = type(detail)(detail.array, (*grey.shape, 1))
        return signal.replace(signal.value + signal.by_colour(self.amount) * detail)
