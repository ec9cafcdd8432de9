"""Ambient light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import per_colour
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class AmbientLight(Effect):
    """Light from the room reaches the whole sensor evenly, whatever the lamps do.

        rate' = rate + a    by colour, in every lit shot;    rate' = rate + share a    in a dark one

    A dark shot with the lamps off in the lit room has it too (share 1); one with the cap on has
    not (share 0). The offset grows with the exposure, not with the level of the lamps, and brings
    shot noise whose variance in e-^2 is the added mean in e-: extra read noise of that variance
    leaves the mean alone, a black level adds no variance. Even with the cap off it is told from
    dark current only by its colour, and by capping the lens.
    """

    name: ClassVar[str] = "ambient_light"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 60
    reference: ClassVar[str] = "additive background light; EMVA 1288 release 4 asks for a dark room"

    rate_e_per_s: float | Colours = parameter(
        2000.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e6,
        identity=0.0,
        per_colour=True,
        doc="light of the room, as photo-electrons per second in a pixel of this camera",
    )
    share_in_dark: float = parameter(
        1.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        starts=(1.0, 0.0),
        doc="part of it that is left in dark shots: 1 with the lamp off, 0 with the cap on",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        share = self.share_in_dark if signal.shot.dark else 1.0
        added = Colours.of(self.rate_e_per_s).map(lambda rate: rate * share)
        return signal.replace(signal.value + per_colour(signal, added))
