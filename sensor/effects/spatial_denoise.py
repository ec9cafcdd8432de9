"""Edge-preserving noise filter in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.interpolation import Row
from sensor.neighbours import Neighbours, Runs, interleaved
from sensor.planes import Planes
from sensor.signal import Signal
from sensor.stream import Stream

_AROUND = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]


@dataclass(frozen=True, kw_only=True)
class SpatialDenoise(Effect):
    """Each pixel moves towards those of its eight neighbours that are nearly equal to it.

        DN' = DN + s / (1 + sum of w_j) sum of w_j d_j,    d_j = DN_j - DN, both sums over |d_j| < T

    where w_j is 1 for straight neighbours and w for diagonal ones. With w = 1 this is Lee's sigma
    filter, and with s = 1 as well the mean over all alike pixels; a small w is a round window, as
    that of a narrow normal distribution. Each colour is filtered by itself, on a mosaic among
    pixels of the same colour. Where noise is well below T its variance falls, for W = 5 + 4w, by
    (1 - s (W - 1) / W)^2 + 4 (1 + w^2) (s / W)^2 and neighbours become correlated, while an edge
    higher than T stays as steep as it was: a linear blur that takes as much noise away softens it.
    """

    name: ClassVar[str] = "spatial_denoise"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 40
    reference: ClassVar[str] = (
        "Lee, Digital image smoothing and the sigma filter, CVGIP 24, 255 (1983)"
    )

    strength: float = parameter(
        0.6,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        identity=0.0,
        doc="how far a pixel moves towards the mean of those alike",
    )
    threshold_dn: float = parameter(
        4.0,
        unit="DN",
        minimum=0.0,
        maximum=65536.0,
        identity=0.0,
        starts=(4.0, 64.0),
        doc="difference from which a neighbour counts as another object",
    )
    diagonal: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        starts=(1.0, 0.25),
        doc="weight of a diagonal neighbour over that of a straight one",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        number = dr.array_t(signal.backend.arrays.TensorXf)
        # figures are data, so that a new value compiles nothing
        threshold = dr.opaque(number, self.threshold_dn)
        strength = dr.opaque(number, self.strength)
        diagonal = dr.opaque(number, self.diagonal)

        def smooth(own: Any, around: list[Any]) -> Any:
            straight, oblique = (own * 0.0, own * 0.0), (own * 0.0, own * 0.0)
            for (dy, dx), other in zip(_AROUND, around, strict=True):
                difference = other - own
                alike = dr.abs(difference) < threshold
                total, count = oblique if dy and dx else straight
                more = (
                    dr.select(alike, total + difference, total),
                    dr.select(alike, count + 1.0, count),
                )
                straight, oblique = (straight, more) if dy and dx else (more, oblique)
            total = dr.fma(diagonal, oblique[0], straight[0])
            count = dr.fma(diagonal, oblique[1], straight[1] + 1.0)
            return own + strength * total / count

        if not signal.coloured:
            near = Neighbours(signal)
            step = 2 if len(set(signal.format.cfa)) > 1 else 1
            around = [near.flat_at(dy * step, dx * step) for dy, dx in _AROUND]
            smoothed = smooth(near.flat_at(0, 0), around)
            return signal.replace(type(signal.value)(smoothed, signal.shape))
        rows = signal.interpolated.rows(1) if signal.interpolated else _rows(signal)
        length = len(rows[0][0]) - 2
        colours = tuple(
            tuple(
                smooth(rows[1][c][k], [rows[1 + dy][c][k + dx] for dy, dx in _AROUND])
                for k in range(1, length + 1)
            )
            for c in range(3)
        )
        return signal.replace(
            Planes(colours=colours, shape=signal.shape, arrays=signal.backend.arrays)
        )


def _rows(signal: Signal) -> list[Row]:
    """Three colours of the rows about each run, of numbers that lie in memory for it."""
    flats = [interleaved(list(parts)) for parts in signal.planes.colours]
    dr.eval(flats)
    tensor = signal.backend.arrays.TensorXf
    runs = [Runs(signal.replace(tensor(flat, signal.shape[:3]))) for flat in flats]
    red, green, blue = runs
    return [(red.line(dy), green.line(dy), blue.line(dy)) for dy in (-1, 0, 1)]
