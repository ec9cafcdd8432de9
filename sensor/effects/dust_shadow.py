"""Dust on the sensor's window."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant, from_centre_px
from sensor.signal import Signal
from sensor.stream import Stream

SOFTNESS = 0.5
"""Width of the penumbra relative to the shadow's diameter; assumed: the window's height over the
chip times the opening of the lens is of the order of the grain."""


@dataclass(frozen=True, kw_only=True)
class DustShadow(Effect):
    """Grains on the window over the chip cast soft shadows that stay with the camera body.

        rate' = rate x product of (1 - depth p_i),
        p_i = clip((R_i (1 + s) - rho_i) / (2 s R_i), 0, 1),    s = 1/2

    rho_i is the distance from grain i: full depth in the core, a straight penumbra, nothing beyond.
    Places and sizes (1/2 to 3/2 of the mean) belong to the body. Whatever its size, a lone shadow
    has sum of p^2 over sum of p equal to (1 - (2/3) s + s^2 / 3) / (1 + s^2 / 3): 9/13, while a
    Gaussian spot has 1/2 and independent pixel gains have no sum of one sign. A shadow takes its
    part of any light and nothing in the dark.
    """

    name: ClassVar[str] = "dust_shadow"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 70
    product: ClassVar[bool] = True
    reference: ClassVar[str] = "Willson et al., i-SAIRAS 2005: an optical model of dust"

    number: float = parameter(
        8.0,
        unit="1",
        minimum=0.0,
        maximum=500.0,
        identity=0.0,
        doc="how many grains, rounded to a whole number",
    )
    diameter_px: float = parameter(
        12.0, unit="px", minimum=1.0, maximum=200.0, doc="mean diameter of a shadow at half depth"
    )
    depth: float = parameter(
        0.05,
        unit="1",
        minimum=0.0,
        maximum=0.9,
        identity=0.0,
        doc="part of the light that the core of a shadow lacks",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        number = round(self.number)
        if number == 0:
            return signal.replace(signal.value)
        height, width = signal.shape[1:3]
        body = stream.body
        downs = (body.uniform(number, use="down") - 0.5) * float(height)
        rights = (body.uniform(number, use="right") - 0.5) * float(width)
        sizes = body.uniform(number, use="size") + 0.5
        tables = [downs.array, rights.array, sizes.array]
        dr.eval(*tables)

        even = dr.zeros(type(signal.value), (1, height, width, 1))
        down, right = ((place + even).array for place in from_centre_px(signal))
        radius = constant(signal, self.diameter_px / 2).array
        depth = constant(signal, self.depth).array
        kind, index = type(down), dr.uint32_array_t(type(down))
        last = dr.opaque(signal.backend.arrays.UInt32, number)

        def step(grain: Any, left: Any) -> tuple[Any, Any]:
            y, x, size = (dr.gather(kind, table, index(grain)) for table in tables)
            rho = dr.sqrt((down - y) * (down - y) + (right - x) * (right - x))
            r = radius * size
            shadow = dr.clip((r * (1.0 + SOFTNESS) - rho) / (2.0 * SOFTNESS * r), 0.0, 1.0)
            return grain + 1, left * (1.0 - depth * shadow)

        start = (signal.backend.arrays.UInt32(0), dr.zeros(kind, height * width) + 1.0)
        _, left = dr.while_loop(
            start, lambda grain, left: grain < last, step, labels=("grain", "left")
        )
        return signal.replace(signal.value * type(even)(left, (1, height, width, 1)))
