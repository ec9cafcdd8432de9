"""Edge-preserving noise filter in space."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.neighbours import Neighbours, Runs, interleaved
from sensor.signal import Signal
from sensor.stream import Stream

_AROUND = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if dy or dx]


@dataclass(frozen=True, kw_only=True)
class SpatialDenoise(Effect):
    """Each pixel moves towards those of its eight neighbours that are nearly equal to it.

        DN' = DN + s / (1 + m) sum of d_j over the m neighbours with |d_j| < T,  d_j = DN_j - DN

    Lee's sigma filter; with s = 1 it is the mean over all alike pixels. Each colour is filtered by
    itself, on a mosaic among pixels of the same colour. Where noise is well below T its variance
    falls by (1 - 8s/9)^2 + 8 (s/9)^2 and neighbours become correlated, while an edge higher than T
    stays as steep as it was: a linear blur that takes as much noise away softens it.
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

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        number = dr.array_t(signal.backend.arrays.TensorXf)
        # figures are data, so that a new value compiles nothing
        threshold = dr.opaque(number, self.threshold_dn)
        strength = dr.opaque(number, self.strength)

        def smooth(own: Any, around: list[Any]) -> Any:
            total, alike = own * 0.0, own * 0.0 + 1.0
            for other in around:
                difference = other - own
                counts = dr.abs(difference) < threshold
                total += dr.select(counts, difference, 0.0)
                alike += dr.select(counts, 1.0, 0.0)
            return own + strength * total / alike

        if not signal.coloured:
            near = Neighbours(signal)
            step = 2 if len(set(signal.format.cfa)) > 1 else 1
            around = [near.flat_at(dy * step, dx * step) for dy, dx in _AROUND]
            smoothed = smooth(near.flat_at(0, 0), around)
            return signal.replace(type(signal.value)(smoothed, signal.shape))
        planes = signal.planes
        colours = []
        for parts in planes.colours:
            plane = signal.backend.arrays.TensorXf(interleaved(list(parts)), signal.shape[:3])
            runs = Runs(signal.replace(plane))
            lines = [runs.line(dy) for dy in (-1, 0, 1)]
            colours.append(
                tuple(
                    smooth(lines[1][k + 1], [lines[dy + 1][k + 1 + dx] for dy, dx in _AROUND])
                    for k in range(runs.length)
                )
            )
        return signal.replace(dataclasses.replace(planes, colours=tuple(colours)))
