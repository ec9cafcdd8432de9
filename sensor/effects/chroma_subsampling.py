"""Chroma subsampling."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.luma import BLUE, GREEN, RED, need_colours
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ChromaSubsampling(Effect):
    """The cable carries luma for every pixel and colour once for 2 or 4 pixels of a row.

        Y = round(0.299 R + 0.587 G + 0.114 B)
        U = round(mean of (B - Y)/1.772),  V = round(mean of (R - Y)/1.402)    over the group
        R' = Y + 1.402 V,  B' = Y + 1.772 U,  G' = Y - (0.299 1.402 V + 0.114 1.772 U)/0.587

    All in whole codes of the full range, as video modes of IIDC carry them, or in fractions of
    codes, as programs do that keep floats to the end. R, G and B are whole codes before, as where
    a program gets pictures, or not yet, as in a camera whose converter has more bits. Colour
    differences are equal in a group but for rounding and differ between groups; their noise
    variance is 1/n of what it was if the pixels were independent. A blur of the colours has no
    groups.
    """

    name: ClassVar[str] = "chroma_subsampling"
    stage: ClassVar[Stage] = Stage.TRANSPORT
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "ITU-R BT.601-7 for the matrix; IIDC 1394-based Digital Camera Specification 1.31, "
        "modes YUV 4:2:2 and 4:1:1"
    )

    mode: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=2.0,
        identity=0.0,
        whole=True,
        doc="0 carries RGB, 1 is 4:2:2 (2 pixels share a colour), 2 is 4:1:1 (4 pixels)",
    )
    whole_codes: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        whole=True,
        starts=(1.0, 0.0),
        doc="1 carries Y, U and V as whole codes, 0 as fractions: a program that counts in floats",
    )
    of_whole_codes: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        whole=True,
        starts=(1.0, 0.0),
        doc="1 where R, G and B are whole codes before, 0 where they have not been rounded",
    )

    @property
    def rounds(self) -> bool:
        return self.mode > 0 and self.of_whole_codes == 0

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        need_colours(signal, self.name)
        if self.mode == 0:
            return signal.replace(signal.value)
        group = 2 ** int(self.mode)
        planes = signal.planes
        if len(planes.colours[0]) % 4 == 0:  # columns of a lane, which are whole groups
            pixels = list(zip(*planes.colours, strict=True))
            codes = []
            for first in range(0, len(pixels), group):
                members = pixels[first : first + group]
                mean = [sum(pixel[c] / group for pixel in members) for c in range(3)]
                codes += [self._carried(pixel, mean, signal) for pixel in members]
            colours = tuple(zip(*codes, strict=True))
            return signal.replace(dataclasses.replace(planes, colours=colours))
        pixel = [parts[0] for parts in planes.colours]
        dr.eval(pixel)
        _, _, column = signal.coordinates()
        here = dr.arange(type(column), dr.width(column))
        first, last = column - (column & (group - 1)), signal.shape[2] - 1
        mean = [plane * 0.0 for plane in pixel]
        for k in range(group):
            at = here - column + dr.minimum(first + k, last)
            mean = [
                total + dr.gather(type(plane), plane, at) / group
                for total, plane in zip(mean, pixel, strict=True)
            ]
        colours = tuple((plane,) for plane in self._carried(pixel, mean, signal))
        return signal.replace(dataclasses.replace(planes, colours=colours))

    def _carried(self, pixel: Sequence[Any], mean: Sequence[Any], signal: Signal) -> list[Any]:
        """Red, green and blue of a pixel after the cable, from its own and its group's mean."""
        (red, green, blue), (far_red, far_green, far_blue) = pixel, mean
        grey = RED * far_red + GREEN * far_green + BLUE * far_blue
        top, half = float(signal.format.top_dn), float(2 ** (signal.format.bits - 1))

        def code(value: Any) -> Any:
            return dr.round(value) if self.whole_codes else value

        u = dr.clip(code((far_blue - grey) / (2 * (1 - BLUE))), -half, half - 1)
        v = dr.clip(code((far_red - grey) / (2 * (1 - RED))), -half, half - 1)
        y = code(RED * red + GREEN * green + BLUE * blue)
        to_blue, to_red = 2 * (1 - BLUE) * u, 2 * (1 - RED) * v
        planes = [y + to_red, y - (RED * to_red + BLUE * to_blue) / GREEN, y + to_blue]
        return [dr.clip(dr.round(plane), 0.0, top) for plane in planes]
