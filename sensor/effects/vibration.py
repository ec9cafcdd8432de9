"""Vibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant
from sensor.limits import at_least
from sensor.neighbours import Neighbours, Places, fetched_anywhere, moved_on
from sensor.sampled import Sampled
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.whole_numbers import whole_number


@dataclass(frozen=True, kw_only=True)
class Vibration(Effect):
    """The camera trembles: slower than a frame it shifts the picture, faster it blurs it.

        rate'_k(p) = mean over the exposure of rate(p - d_k - e(t)),
        d_k ~ N(0, shift^2) anew in each frame, e(t) of standard deviation blur, on each axis

    Both act through the parabola of three samples a side, which moves ramps and parabolas exactly.
    An edge of slope g flickers with variance g^2 shift^2, the whole edge in step, on top of its
    shot noise; even areas do not. Independent noise of that variance averages out along the edge.
    """

    name: ClassVar[str] = "vibration"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 45
    reference: ClassVar[str] = "Hadar, Fisher and Kopeika, Opt. Eng. 31, 581 (1992)"

    shift_px: float = parameter(
        0.15,
        unit="px",
        minimum=0.0,
        maximum=2.0,
        identity=0.0,
        doc="standard deviation of the picture's place from frame to frame, on each axis",
    )
    blur_px: float = parameter(
        0.3,
        unit="px",
        minimum=0.0,
        maximum=0.7,
        identity=0.0,
        doc="standard deviation of the motion within an exposure, on each axis",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.shot.dark:
            return signal.replace(signal.value)
        if self.shift_px == 0.0:
            along = _blur(constant(signal, self.blur_px).array)
            weights = {
                (dy, dx): along[1 + dy] * along[1 + dx] for dy, dx in product((-1, 0, 1), repeat=2)
            }
            return signal.replace(Neighbours(signal).weighted(weights))
        return signal.replace(self._shifted(signal, stream))

    def _shifted(self, signal: Signal, stream: Stream) -> Sampled:
        """Every frame moved by its own displacement: (F, H, W, 3)."""
        f, height, width, depth = signal.shape
        rows, columns = height + 2 * _MARGIN, width + 2 * _MARGIN
        arrays = signal.backend.arrays
        flat = _with_margin(signal, _blur(constant(signal, self.blur_px).array))
        down, right = (
            (constant(signal, self.shift_px) * stream.normal(1, 1, 1, use=use)).array
            for use in ("down", "right")
        )
        dr.eval(flat, down, right)

        def moved(places: Places, colours: Sequence[Any]) -> list[list[Any]]:
            """Runs by colour, from the three rows and columns about where they come from."""
            up, row_weights = _taps(dr.gather(type(flat), down, places.frame))
            left, column_weights = _taps(dr.gather(type(flat), right, places.frame))
            line = places.row + (_MARGIN - 1) - up
            start = line * columns + places.first + (_MARGIN - 1) - left
            runs = []
            for colour in colours:
                picture = places.frame * depth + colour if f > 1 else colour
                place = picture * (rows * columns) + start
                lines = [
                    fetched_anywhere(flat, place + k * columns, places.length + 2) for k in range(3)
                ]
                sums = [_weighted(samples, row_weights) for samples in zip(*lines, strict=True)]
                sums = moved_on(sums, place)
                runs.append(
                    [
                        at_least(_weighted(sums[k : k + 3], column_weights), 0.0)
                        for k in range(places.length)
                    ]
                )
            return runs

        shape = (len(signal.frames), height, width, depth)
        return Sampled(make=moved, shape=shape, arrays=arrays)


_MARGIN = 16
"""Pixels about the picture: no displacement is as large, as normal numbers end at 6.7."""


def _with_margin(signal: Signal, along: Sequence[Any]) -> Any:
    """The blurred rate colour by colour with mirrored pixels about it: flat, f 3 H' W'.

    Args:
        signal: the rate.
        along: weights of the three samples about a pixel on each axis.
    """
    f, height, width, depth = signal.shape
    flat = signal.value.array
    dr.eval(flat)
    index = dr.uint32_array_t(type(flat))
    whole = dr.int32_array_t(index)

    def summed(samples: Any, place: Any, length: int, start: Any, step: int) -> Any:
        """The sum over the three about a place of an axis, where they are `step` apart."""
        numbers = []
        for k in (-1, 0, 1):
            mirrored = length - 1 - dr.abs(length - 1 - dr.abs(whole(place) + (k - _MARGIN)))
            at = index(dr.clip(mirrored, 0, length - 1))
            numbers.append(dr.gather(type(flat), samples, start + at * step))
        return _weighted(numbers, along)

    columns, rows, numbers = width + 2 * _MARGIN, height + 2 * _MARGIN, width * depth
    lane = dr.arange(index, f * rows * numbers)
    line = lane // numbers
    frame = line // rows
    start = frame * (height * numbers) + lane - line * numbers
    taller = summed(flat, line - frame * rows, height, start, numbers)
    dr.eval(taller)
    lane = dr.arange(index, f * depth * rows * columns)
    line = lane // columns
    picture = line // rows
    frame = picture // depth
    start = (frame * rows + line - picture * rows) * numbers + picture - frame * depth
    return summed(taller, lane - line * columns, width, start, depth)


def _weighted(samples: Sequence[Any], weights: Sequence[Any]) -> Any:
    first, *more = zip(samples, weights, strict=True)
    total = first[0] * first[1]
    for sample, weight in more:
        total = dr.fma(sample, weight, total)
    return total


def _blur(sigma: Any) -> tuple[Any, Any, Any]:
    """Weights of the three pixels about a pixel, of variance sigma^2."""
    side = 0.5 * sigma * sigma
    return side, 1.0 - 2.0 * side, side


def _taps(shift: Any) -> tuple[Any, list[Any]]:
    """How many whole pixels a shift has, unsigned, and the weights of the three about there."""
    nearest = dr.clip(dr.round(shift), 1.0 - _MARGIN, _MARGIN - 1.0)
    t = nearest - shift
    half = 0.5 * t
    return whole_number(nearest), [half * (t - 1.0), 1.0 - t * t, half * (t + 1.0)]
