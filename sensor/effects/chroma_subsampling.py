"""Chroma subsampling."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter, switch
from sensor.luma import BLUE, GREEN, RED, need_colours
from sensor.neighbours import interleaved
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ChromaSubsampling(Effect):
    """The cable carries luma for every pixel and colour once for n = 2 or 4 pixels of a row.

        Y = round(0.299 R + 0.587 G + 0.114 B)
        U = round(mean of (B - Y)/1.772),  V = round(mean of (R - Y)/1.402)    over the group
        R' = Y + 1.402 V,  B' = Y + 1.772 U,  G' = Y - (0.299 1.402 V + 0.114 1.772 U)/0.587

    All in whole codes of the full range, as video modes of IIDC carry them, or in fractions of
    codes, as programs do that keep floats to the end. Libraries that count in integers round Y, U
    and V of each pixel, then their means, of which halves go up; so do programs that round each
    plane of Y, U and V, which take the differences before Y is rounded.
    R, G and B are whole codes before, as where a program gets pictures, or not yet, as in a camera
    whose converter has more bits.
    BT.601 has its colours at the first pixel of a group: they are taken there, by a triangle of
    weights (n - |k|)/n^2 or from that pixel alone. Who shows the picture repeats a colour over the
    group, or draws straight lines from one to the next, in fractions or as planes of whole codes.
    Two rows may share their colours in the same way.
    Colour differences of a row lie in as many dimensions as there are groups, but for rounding;
    repeated, they are equal in a group, and their noise variance is 1/n of what it was if the
    pixels were independent. A blur of the colours has no groups.
    """

    name: ClassVar[str] = "chroma_subsampling"
    stage: ClassVar[Stage] = Stage.TRANSPORT
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "ITU-R BT.601-7 for the matrix and the place of colours; IIDC 1394-based Digital Camera "
        "Specification 1.31, modes YUV 4:2:2 and 4:1:1"
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
        maximum=3.0,
        whole=True,
        starts=(1.0,),
        doc="1 carries whole codes, 2 counts in integers, with lines in fixed point, 3 rounds each"
        " plane, 0 carries fractions",
    )
    of_whole_codes: float = switch(
        1.0,
        starts=(1.0,),
        doc="1 where R, G and B are whole codes before, 0 where they have not been rounded",
    )

    taken: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=2.0,
        whole=True,
        starts=(0.0,),
        doc="0 takes the mean of a group, 1 a triangle about its first pixel, 2 that pixel alone",
    )
    rows: float = parameter(
        1.0,
        unit="1",
        minimum=1.0,
        maximum=2.0,
        whole=True,
        starts=(1.0,),
        doc="1 carries colours in every row, 2 once for two rows, as 4:2:0 does with mode 1",
    )
    drawn: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=2.0,
        whole=True,
        starts=(0.0,),
        doc="0 repeats a colour over its group, 1 draws straight lines, 2 those in whole codes",
    )

    @property
    def rounds(self) -> bool:
        return self.mode > 0 and self.of_whole_codes == 0

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        need_colours(signal, self.name)
        if self.mode == 0:
            return signal.replace(signal.value)
        group, planes = 2 ** int(self.mode), signal.planes
        in_itself = self.taken == 0 and self.drawn == 0 and self.rows == 1
        if in_itself and len(planes.colours[0]) % 4 == 0:  # columns of a lane: whole groups
            pixels = list(zip(*planes.colours, strict=True))
            codes = []
            for first in range(0, len(pixels), group):
                members = pixels[first : first + group]
                own = [self._differences(pixel) for pixel in members]
                mean = [sum(one) / group for one in zip(*own, strict=True)]
                carried = self._carried(mean, signal)
                codes += [self._shown(pixel, carried, signal) for pixel in members]
            colours = tuple(zip(*codes, strict=True))
            return signal.replace(dataclasses.replace(planes, colours=colours))
        pixel = [interleaved(list(parts)) for parts in planes.colours]
        differences = self._differences(pixel)
        dr.eval(pixel, differences)
        _, height, width = signal.shape[:3]
        frame, row, column = signal.coordinates()
        start = frame * (height * width)
        rows = int(self.rows)

        def carried_at(down: Any, across: Any) -> list[Any]:
            """The colour of a group, by its number down and across."""
            total = [plane * 0.0 for plane in differences]
            for (y, part), (x, weight) in product(self._from(rows), self._from(group)):
                at = _inside(down * rows, y, height) * width + _inside(across * group, x, width)
                total = [
                    so_far + part * weight * dr.gather(type(plane), plane, start + at)
                    for so_far, plane in zip(total, differences, strict=True)
                ]
            return self._carried(total, signal)

        number = type(pixel[0])
        carried = [pixel[0] * 0.0, pixel[0] * 0.0]
        for down, part in self._groups_of(row, rows, height, number):
            line = [pixel[0] * 0.0, pixel[0] * 0.0]
            for across, weight in self._groups_of(column, group, width, number):
                u, v = carried_at(down, across)
                line = [line[0] + weight * u, line[1] + weight * v]
            carried = [
                plane + self._part_of_a_line(part, one)
                for plane, one in zip(carried, line, strict=True)
            ]
        carried = [self._as_drawn(plane) for plane in carried]
        colours = tuple((plane,) for plane in self._shown(pixel, carried, signal))
        return signal.replace(dataclasses.replace(planes, colours=colours))

    @property
    def _in_fixed_point(self) -> bool:
        """Whether lines are drawn by integers: each row gives quarters of a code, and what is less
        than one of these is cut off, as by OpenCV's resize.
        """
        return self.whole_codes == 2 and self.drawn == 2

    def _part_of_a_line(self, part: Any, line: Any) -> Any:
        """What a line of colours gives to those drawn between two."""
        return dr.floor(part * 4.0 * line) if self._in_fixed_point else part * line

    def _as_drawn(self, plane: Any) -> Any:
        """Colours of all pixels as a program keeps them."""
        if self._in_fixed_point:
            return dr.floor((plane + 2.0) / 4.0)
        return self._whole(plane) if self.drawn == 2 else plane

    def _from(self, group: int) -> list[tuple[int, float]]:
        """What each pixel gives to the colour of a group along one axis, by its place from the
        group's first.
        """
        if self.taken == 0:
            return [(k, 1.0 / group) for k in range(group)]
        if self.taken == 2:
            return [(0, 1.0)]
        return [(k, (group - abs(k)) / group**2) for k in range(1 - group, group)]

    def _groups_of(self, place: Any, group: int, size: int, number: Any) -> list[tuple[Any, Any]]:
        """The groups whose colours a pixel shows along one axis, and how much of each."""
        if not self.drawn or group == 1:
            return [(place // group, 1.0)]
        # straight lines from the middle of a group to that of the next, or from first to first
        later, offset = (place + group // 2, 0.5) if self.taken == 0 else (place + group, 0.0)
        part = (number(later % group) + offset) / group
        one = dr.maximum(later // group, 1) - 1
        other = dr.minimum(later // group, (size - 1) // group)
        return [(one, 1.0 - part), (other, part)]

    def _code(self, value: Any) -> Any:
        return self._whole(value) if self.whole_codes else value

    def _whole(self, value: Any) -> Any:
        """The nearest whole code; of what is kept in planes, a half goes up."""
        return dr.floor(value + 0.5) if self.whole_codes >= 2 else dr.round(value)

    def _differences(self, pixel: Sequence[Any]) -> list[Any]:
        """U and V of a pixel by itself, before their mean is taken."""
        red, green, blue = pixel
        each = dr.round if self.whole_codes >= 2 else _as_it_is
        grey = RED * red + GREEN * green + BLUE * blue
        if self.whole_codes == 2:
            grey = each(grey)
        return [each((blue - grey) / (2 * (1 - BLUE))), each((red - grey) / (2 * (1 - RED)))]

    def _carried(self, mean: Sequence[Any], signal: Signal) -> list[Any]:
        """U and V of a group, as the cable has them."""
        half = float(2 ** (signal.format.bits - 1))
        return [dr.clip(self._code(one), -half, half - 1) for one in mean]

    def _shown(self, pixel: Sequence[Any], carried: Sequence[Any], signal: Signal) -> list[Any]:
        """Red, green and blue of a pixel after the cable, from its own and the U and V it shows."""
        (red, green, blue), (u, v) = pixel, carried
        y = self._code(RED * red + GREEN * green + BLUE * blue)
        to_blue, to_red = 2 * (1 - BLUE) * u, 2 * (1 - RED) * v
        planes = [y + to_red, y - (RED * to_red + BLUE * to_blue) / GREEN, y + to_blue]
        top = float(signal.format.top_dn)
        return [dr.clip(dr.round(plane), 0.0, top) for plane in planes]


def _as_it_is(value: Any) -> Any:
    return value


def _inside(first: Any, shift: int, size: int) -> Any:
    """Places so far from others, those beyond the border at the border."""
    # those left of the first are below 0 in whole numbers with a sign
    return type(first)(dr.clip(dr.int32_array_t(type(first))(first) + shift, 0, size - 1))
