"""Edge-preserving noise filter in space."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.interpolation import Row
from sensor.neighbours import Neighbours, Runs, interleaved
from sensor.planes import Planes
from sensor.powers import two_to
from sensor.signal import Signal
from sensor.stream import Stream

_FARTHEST = {1: 2, 2: 4, 3: 8}
"""Square of the distance of the last neighbours in each window."""

_TOGETHER, _PATCHES = 2, 3
"""What is as soft by all colours together, and by what lies around both pixels."""

_PATCH = tuple((dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1))
"""Rows below and columns right of a pixel of what is compared."""

_LEAST_DN, _LEAST_WEIGHT = 1e-3, 1e-6
"""Of a threshold and of a weight that one divides by."""

_At = Callable[[int, int], list[Any]]
"""The colours so many rows below a pixel and so many columns right of it."""


@dataclass(frozen=True, kw_only=True)
class SpatialDenoise(Effect):
    """Each pixel moves towards those of its neighbours that are nearly equal to it.

        DN' = DN + s / (w_0 + sum of w_j t_j) sum of w_j t_j d_j,    d_j = DN_j - DN

    where t_j is 1 for |d_j| < T and 0 beyond, or exp(-d_j^2 / 2T^2) if it is soft. A neighbour at a
    distance r has the weight w_j = w^(r^2 - 1): 1 if it is a straight one and w if it is diagonal.
    The pixel's own weight w_0 is 1, and 1 / w if it is soft. With w = 1 and 3 x 3 pixels this is
    Lee's sigma filter, and with s = 1 as well the mean over all alike pixels; a small w is a round
    window, as that of a normal distribution of variance -1 / (2 ln w), and a soft one with it is
    the bilateral filter. Each colour is filtered by itself, unless the three differences add up to
    one |d_j|; on a mosaic among pixels of the same colour. In non-local means t_j has the mean
    square of what the 3 x 3 pixels about both differ by for d_j^2.
    Where noise is well below T its variance falls by the sum of squares of all weights,
    (1 - s (W - 1) / W)^2 + 4 (1 + w^2) (s / W)^2 for 3 x 3 pixels and W = 5 + 4w, and neighbours
    become correlated, while an edge higher than T stays as steep as it was: a linear blur that
    takes as much noise away softens it.
    """

    name: ClassVar[str] = "spatial_denoise"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 40
    product: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "Lee, Digital image smoothing and the sigma filter, CVGIP 24, 255 (1983); Tomasi and "
        "Manduchi, Bilateral filtering for gray and color images, ICCV (1998); Buades, Coll and "
        "Morel, A non-local algorithm for image denoising, CVPR (2005)"
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
    window: float = parameter(
        1.0,
        unit="1",
        minimum=1.0,
        maximum=3.0,
        whole=True,
        starts=(1.0,),
        doc="1 of 3 x 3 pixels, 2 those up to 2 pixels away, 3 of 5 x 5",
    )
    soft: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=3.0,
        whole=True,
        starts=(0.0,),
        doc="0 what is below the threshold counts in full; soft: 1 each colour by itself, 2 all "
        "colours together, 3 by patches of 3 x 3 pixels",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        places = self._places()
        reach = max(dx for _, dx in places) + (self.soft == _PATCHES)
        smooth = self._smooth(dr.array_t(signal.backend.arrays.TensorXf), places)
        if not signal.coloured:
            near = Neighbours(signal)
            step = 2 if len(set(signal.format.cfa)) > 1 else 1
            at_place = functools.cache(lambda dy, dx: [near.flat_at(dy * step, dx * step)])
            (smoothed,) = smooth(at_place)
            return signal.replace(type(signal.value)(smoothed, signal.shape))
        rows = signal.interpolated.rows(reach) if signal.interpolated else _rows(signal, reach)

        def at(k: int) -> _At:
            return lambda dy, dx: [columns[k + dx + reach] for columns in rows[dy + reach]]

        run = [smooth(at(k)) for k in range(len(rows[0][0]) - 2 * reach)]
        colours = tuple(zip(*run, strict=True))
        return signal.replace(
            Planes(colours=colours, shape=signal.shape, arrays=signal.backend.arrays)
        )

    def _smooth(self, number: Any, places: list[tuple[int, int]]) -> Callable[[_At], list[Any]]:
        """What a pixel becomes, by its colours and those of its neighbours."""
        # figures are data, so that a new value compiles nothing
        limit_dn = max(self.threshold_dn, _LEAST_DN)
        threshold = dr.opaque(number, limit_dn)
        octaves = dr.opaque(number, -0.5 / (math.log(2.0) * limit_dn**2))
        strength = dr.opaque(number, self.strength)
        diagonal = dr.opaque(number, self.diagonal)
        own = 1.0 / max(self.diagonal, _LEAST_WEIGHT) if self.soft else 1.0
        own_weight = dr.opaque(number, own)

        def alike(at: _At, dy: int, dx: int) -> list[Any]:
            if self.soft == _PATCHES:
                unlike = [_apart(at(dy + y, dx + x), at(y, x)) for y, x in _PATCH]
                return [
                    two_to(sum(map(dr.square, one)) * octaves / len(_PATCH))
                    for one in zip(*unlike, strict=True)
                ]
            apart = _apart(at(dy, dx), at(0, 0))
            if self.soft == _TOGETHER:
                apart = [sum(map(dr.abs, apart))] * len(apart)
            if self.soft:
                return [two_to(dr.square(one) * octaves) for one in apart]
            return [dr.select(dr.abs(one) < threshold, 1.0, 0.0) for one in apart]

        def smooth(at: _At) -> list[Any]:
            own = at(0, 0)
            weight = {1: own[0] * 0.0 + 1.0}
            for farther in range(2, _FARTHEST[int(self.window)] + 1):
                weight[farther] = weight[farther - 1] * diagonal
            total, count = [0.0 * one for one in own], [0.0 * one + own_weight for one in own]
            for dy, dx in places:
                apart, near = _apart(at(dy, dx), own), weight[dy * dy + dx * dx]
                shares = [near * one for one in alike(at, dy, dx)]
                total = [dr.fma(s, d, t) for s, d, t in zip(shares, apart, total, strict=True)]
                count = [n + s for n, s in zip(count, shares, strict=True)]
            return [o + strength * t / n for o, t, n in zip(own, total, count, strict=True)]

        return smooth

    def _places(self) -> list[tuple[int, int]]:
        """Rows below and columns right of a pixel of its neighbours in the window."""
        reach = range(-2, 3)
        inside = range(1, _FARTHEST[int(self.window)] + 1)
        return [(dy, dx) for dy in reach for dx in reach if dy * dy + dx * dx in inside]


def _apart(theirs: list[Any], ours: list[Any]) -> list[Any]:
    return [their - our for their, our in zip(theirs, ours, strict=True)]


def _rows(signal: Signal, reach: int) -> list[Row]:
    """Three colours of the rows about each run, of numbers that lie in memory for it."""
    flats = [interleaved(list(parts)) for parts in signal.planes.colours]
    dr.eval(flats)
    tensor = signal.backend.arrays.TensorXf
    runs = [Runs(signal.replace(tensor(flat, signal.shape[:3]))) for flat in flats]
    red, green, blue = runs
    return [
        (red.line(dy, reach), green.line(dy, reach), blue.line(dy, reach))
        for dy in range(-reach, reach + 1)
    ]
