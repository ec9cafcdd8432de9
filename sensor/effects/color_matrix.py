"""Colour matrix."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.luma import BLUE, GREEN, RED, need_colours
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ColorMatrix(Effect):
    """The camera makes colours more vivid: it moves each channel away from the pixel's luma.

        DN'_c = Y + s (DN_c - Y),    Y = 0.299 R + 0.587 G + 0.114 B

    This is the matrix M = s 1 + (1 - s) (1, 1, 1)^T (0.299, 0.587, 0.114), whose rows add to 1, so
    grey and black stay. Noise of covariance C becomes M C M^T: channels whose noise was independent
    are correlated afterwards, negatively for s > 1, as no crosstalk of light and no noise added
    channel by channel does.
    """

    name: ClassVar[str] = "color_matrix"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 30
    reference: ClassVar[str] = (
        "IIDC 1394-based Digital Camera Specification 1.31, SATURATION; luma of ITU-R BT.601-7"
    )

    saturation: float = parameter(
        1.3,
        unit="1",
        minimum=0.0,
        maximum=3.0,
        identity=1.0,
        doc="factor of the colour differences; 0 is grey",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        need_colours(signal, self.name)
        planes = signal.planes
        change = dr.opaque(dr.array_t(signal.backend.arrays.TensorXf), self.saturation - 1.0)
        pixels = []
        for red, green, blue in zip(*planes.colours, strict=True):
            grey = RED * red + GREEN * green + BLUE * blue
            pixels.append([value + change * (value - grey) for value in (red, green, blue)])
        colours = tuple(zip(*pixels, strict=True))
        return signal.replace(dataclasses.replace(planes, colours=colours))
