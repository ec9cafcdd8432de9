"""Sharpening."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter, switch
from sensor.errors import CameraError
from sensor.luma import BLUE, GREEN, RED
from sensor.neighbours import Neighbours, Runs, interleaved
from sensor.planes import Planes
from sensor.signal import Signal
from sensor.stream import Stream

_SOFT = {(dy, dx): (2 - abs(dy)) * (2 - abs(dx)) / 16 for dy in (-1, 0, 1) for dx in (-1, 0, 1)}
"""The binomial kernel 1-2-1 by 1-2-1."""


@dataclass(frozen=True, kw_only=True)
class Sharpening(Effect):
    """Unsharp masking: what a soft copy lacks is added once more.

        DN'_c = DN_c + a (Y - Y * B^n),    B = (1 2 1)^T (1 2 1) / 16

    Y is luma, as in video; it is the colour itself where each is sharpened alone, as programs for
    pictures do, and the pixel in a camera without colours. n passes of B are as wide as a normal
    distribution of standard deviation sqrt(n / 2) px. Means of flat areas stay. At n = 1 white
    noise of variance v gets the covariance v (h correlated with itself) for
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
    passes: float = parameter(
        1.0,
        unit="1",
        minimum=1.0,
        maximum=8.0,
        whole=True,
        starts=(1.0, 2.0),
        doc="how often the soft copy is softened",
    )
    each_colour: float = switch(
        0.0,
        starts=(0.0, 1.0),
        doc="0 the detail of luma goes to all colours, 1 each colour gets its own",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.coloured and self.each_colour == 0:
            return self._of_luma(signal)
        if signal.coloured or len(set(signal.format.cfa)) == 1:
            soft = _softened(signal, int(self.passes)).value
            return signal.replace(signal.value + self.amount * (signal.value - soft))
        raise CameraError(
            "effect 'sharpening' on a mosaic",
            "expected three colours in every pixel, or a camera without colour filters",
            "add the effect 'demosaic' (with pixels rgb8), or remove this one",
        )

    def _of_luma(self, signal: Signal) -> Signal:
        """Each colour gets the detail of luma."""
        if signal.interpolated and self.passes == 1:
            rows = signal.interpolated.rows(1)
            lines = [[_luma(*pixel) for pixel in zip(*row, strict=True)] for row in rows]
            own, colours = lines[1], [columns[1:-1] for columns in rows[1]]
        else:
            planes = signal.planes
            dr.eval(planes.colours)
            luma = interleaved([_luma(*pixel) for pixel in zip(*planes.colours, strict=True)])
            grey = signal.replace(type(signal.value)(luma, signal.shape[:3]))
            nearly = Runs(_softened(grey, int(self.passes) - 1))
            lines = [nearly.line(dy) for dy in (-1, 0, 1)]
            own, colours = Runs(grey).line(0), list(map(list, planes.colours))
        sharp = []
        for k in range(len(colours[0])):
            soft = sum(weight * lines[dy + 1][k + 1 + dx] for (dy, dx), weight in _SOFT.items())
            sharp.append(own[k + 1] - soft)
        made = tuple(
            tuple(part + self.amount * detail for part, detail in zip(parts, sharp, strict=True))
            for parts in colours
        )
        arrays = signal.backend.arrays
        return signal.replace(Planes(colours=made, shape=signal.shape, arrays=arrays))


def _luma(red: Any, green: Any, blue: Any) -> Any:
    return RED * red + GREEN * green + BLUE * blue


def _softened(signal: Signal, passes: int) -> Signal:
    """A copy that went so many times through the kernel."""
    for _ in range(passes):
        signal = signal.replace(Neighbours(signal).weighted(_SOFT))
    return signal
