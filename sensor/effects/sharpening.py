"""Sharpening."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.errors import CameraError
from sensor.luma import BLUE, GREEN, RED
from sensor.neighbours import Neighbours, Runs, interleaved
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
            return self._of_colours(signal)
        if len(set(signal.format.cfa)) == 1:
            detail = signal.value - Neighbours(signal).weighted(_SOFT)
            return signal.replace(signal.value + signal.by_colour(self.amount) * detail)
        raise CameraError(
            "effect 'sharpening' on a mosaic",
            "expected three colours in every pixel, or a camera without colour filters",
            "add the effect 'demosaic' (with pixels rgb8), or remove this one",
        )

    def _of_colours(self, signal: Signal) -> Signal:
        """Each colour gets the detail of luma."""
        planes = signal.planes
        dr.eval(planes.colours)
        grey = interleaved(
            [RED * r + GREEN * g + BLUE * b for r, g, b in zip(*planes.colours, strict=True)]
        )
        runs = Runs(signal.replace(type(signal.value)(grey, signal.shape[:3])))
        lines = [runs.line(dy) for dy in (-1, 0, 1)]
        sharp = []
        for k in range(runs.length):
            soft = sum(weight * lines[dy + 1][k + 1 + dx] for (dy, dx), weight in _SOFT.items())
            sharp.append(lines[1][k + 1] - soft)
        colours = tuple(
            tuple(part + self.amount * detail for part, detail in zip(parts, sharp, strict=True))
            for parts in planes.colours
        )
        return signal.replace(dataclasses.replace(planes, colours=colours))
