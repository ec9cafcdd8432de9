"""Colour matrix."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.luma import BLUE, GREEN, RED, need_colours
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ColorMatrix(Effect):
    """The camera mixes the colours of each pixel by a matrix whose rows add to 1.

        DN' = S (1 + X) DN

    The matrix 1 + X corrects the filters' spectra: each colour less some part n of the next one
    (green for red, blue for green, red for blue) and l of the last one, so that X has a row
    (-n - l, n, l) for red and so on. Then S = s 1 + (1 - s) (1, 1, 1)^T (0.299, 0.587, 0.114) makes
    colours more vivid: it moves each channel away from the pixel's luma. Grey and black stay. Noise
    of covariance C becomes M C M^T: channels whose noise was independent are correlated afterwards,
    negatively where colours become more vivid, as no crosstalk of light and no noise added channel
    by channel does.
    """

    name: ClassVar[str] = "color_matrix"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 30
    reference: ClassVar[str] = (
        "IIDC 1394-based Digital Camera Specification 1.31, SATURATION; luma of ITU-R BT.601-7;"
        " ColorMatrix of Adobe DNG 1.4"
    )

    saturation: float = parameter(
        1.3,
        unit="1",
        minimum=0.0,
        maximum=3.0,
        identity=1.0,
        doc="factor of the colour differences; 0 is grey",
    )
    next_colour: float | Colours = parameter(
        0.0,
        unit="1",
        minimum=-1.0,
        maximum=1.0,
        identity=0.0,
        per_colour=True,
        doc="part of the next colour in each: of green in red, of blue in green, of red in blue",
    )
    last_colour: float | Colours = parameter(
        0.0,
        unit="1",
        minimum=-1.0,
        maximum=1.0,
        identity=0.0,
        per_colour=True,
        doc="part of the last colour in each: of blue in red, of red in green, of green in blue",
    )

    @property
    def matrix(self) -> NDArray[np.float64]:
        """M, by rows of what it makes: (3, 3)."""
        following, last = Colours.of(self.next_colour), Colours.of(self.last_colour)
        mixed = np.array(
            [
                [1 - following.R - last.R, following.R, last.R],
                [last.G, 1 - following.G - last.G, following.G],
                [following.B, last.B, 1 - following.B - last.B],
            ]
        )
        vivid = self.saturation * np.eye(3) + (1 - self.saturation) * np.array([RED, GREEN, BLUE])
        return np.asarray(vivid @ mixed)

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        need_colours(signal, self.name)
        planes, number = signal.planes, dr.array_t(signal.backend.arrays.TensorXf)
        parts = [[dr.opaque(number, float(part)) for part in row] for row in self.matrix]
        pixels = []
        for pixel in zip(*planes.colours, strict=True):
            # rows add to 1, and a pixel without colour stays to the last bit
            pixels.append(
                [
                    value + sum(parts[c][d] * (pixel[d] - value) for d in range(3) if d != c)
                    for c, value in enumerate(pixel)
                ]
            )
        colours = tuple(zip(*pixels, strict=True))
        return signal.replace(dataclasses.replace(planes, colours=colours))
