"""Lateral chromatic aberration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import from_centre_px, half_diagonal_px, per_colour
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.unresolved import moved, unresolved_edges


@dataclass(frozen=True, kw_only=True)
class LateralChromaticAberration(Effect):
    """The lens draws red and blue a little larger or smaller than green.

        rate'_c(p) = rate_c(p / (1 + s_c / r0)),    p from the centre, r0 its distance to a corner

    s_c is how far outward the colour's picture moves in the corner; it grows with the distance from
    the centre, points along the radius, and leaves green alone. Edges through the centre keep their
    colour, edges far out get fringes of opposite colour on opposite sides. A blur of red and blue
    widens edges, and moves none.
    """

    name: ClassVar[str] = "lateral_chromatic_aberration"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 30
    reference: ClassVar[str] = "Mallon and Whelan, Pattern Recognit. Lett. 28, 125 (2007)"

    red_px: float = parameter(
        0.5,
        unit="px",
        minimum=-10.0,
        maximum=10.0,
        identity=0.0,
        doc="shift of red outward from green in the corners",
    )
    blue_px: float = parameter(
        -0.5,
        unit="px",
        minimum=-10.0,
        maximum=10.0,
        identity=0.0,
        doc="shift of blue outward from green in the corners",
    )
    unresolved: float = unresolved_edges()

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        radius = half_diagonal_px(signal.format)
        shrink = Colours(R=self.red_px, G=0.0, B=self.blue_px).map(
            lambda shift: 1.0 / (1.0 + shift / radius)
        )
        down, right = from_centre_px(signal)
        scale = per_colour(signal, shrink)
        return moved(signal, stream, down * scale, right * scale, self.unresolved)
