"""Vibration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant
from sensor.neighbours import Neighbours
from sensor.signal import Signal
from sensor.stream import Stream


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
        near = Neighbours(signal)
        shaken = signal.replace(near.weighted(_blur(constant(signal, self.blur_px).array)))
        if self.shift_px == 0.0:
            return shaken
        return signal.replace(self._shifted(shaken, stream))

    def _shifted(self, signal: Signal, stream: Stream) -> Any:
        """Every frame moved by its own displacement: a tensor (F, H, W, 3)."""
        flat = signal.value.array
        index = dr.uint32_array_t(type(flat))
        whole = dr.int32_array_t(index)
        down, right = (
            (constant(signal, self.shift_px) * stream.normal(1, 1, 1, use=use)).array
            for use in ("down", "right")
        )
        dr.eval(flat, down, right)

        f, height, width, depth = signal.shape
        frames = len(signal.frames)
        lane = dr.arange(index, frames * height * width * depth)
        line = lane // (width * depth)
        across = lane - line * (width * depth)
        frame = line // height
        rows, row_weights = _taps(line - frame * height, dr.gather(type(flat), down, frame), height)
        column = across // depth
        colour = across - column * depth
        columns, column_weights = _taps(column, dr.gather(type(flat), right, frame), width)
        first = frame * height if f > 1 else whole(0)
        total: Any = 0.0
        for row, down_weight in zip(rows, row_weights, strict=True):
            start = (first + row) * width
            along = sum(
                w * dr.gather(type(flat), flat, (start + c) * depth + colour)
                for c, w in zip(columns, column_weights, strict=True)
            )
            total = total + down_weight * along
        return type(signal.value)(dr.maximum(total, 0.0), (frames, height, width, depth))


def _blur(sigma: Any) -> dict[tuple[int, int], Any]:
    """Weights of the nine pixels about a pixel, of variance sigma^2 on each axis."""
    side = 0.5 * sigma * sigma
    axis = {-1: side, 0: 1.0 - 2.0 * side, 1: side}
    return {(dy, dx): axis[dy] * axis[dx] for dy in axis for dx in axis}


def _taps(place: Any, shift: Any, length: int) -> tuple[list[Any], list[Any]]:
    """The three samples about the place that moves to this one, and their weights."""
    nearest = dr.round(shift)
    t = nearest - shift
    half = 0.5 * t
    source = type(place)
    whole = dr.int32_array_t(type(place))
    centre = whole(place) - whole(nearest)
    places = [
        source(dr.clip(length - 1 - dr.abs(length - 1 - dr.abs(centre + k)), 0, length - 1))
        for k in (-1, 0, 1)
    ]
    return places, [half * (t - 1.0), 1.0 - t * t, half * (t + 1.0)]
