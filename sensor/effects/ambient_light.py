"""Ambient light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import per_colour
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class AmbientLight(Effect):
    """Light from the room reaches the sensor, whatever the lamps do.

        rate' = rate + a (1 - s + s p)    by colour in lit shots, share times that in dark ones

    A part s comes by way of the scene and makes the picture p, the mean of what its lamps show,
    each over its own mean, and brighter towards a window by a slope in the picture's half width and
    one in its half height; the rest is stray light that falls evenly. A dark shot with the lamps
    off in the lit room has it too (share 1); one with the cap on has not (share 0). What is added
    grows with the exposure, not with the level of the lamps, and brings shot noise whose variance
    in e-^2 is the added mean in e-: extra read noise of that variance leaves the mean alone, a
    black level adds no variance. Where it falls evenly and the cap is off, it is told from dark
    current only by its colour, and by capping the lens.
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

    by_the_scene: float = parameter(
        0.0,
        unit="1",
        minimum=0.0,
        maximum=1.0,
        starts=(0.0, 1.0),
        doc="part of it that comes by way of the scene and shows its picture",
    )

    to_the_right: float = parameter(
        0.0,
        unit="1",
        minimum=-1.0,
        maximum=1.0,
        doc="by how much what comes by way of the scene is brighter at the right edge than midway",
    )
    to_the_top: float = parameter(
        0.0,
        unit="1",
        minimum=-1.0,
        maximum=1.0,
        doc="the same at the top",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        share = self.share_in_dark if signal.shot.dark else 1.0
        added = per_colour(signal, Colours.of(self.rate_e_per_s).map(lambda rate: rate * share))
        part = self.by_the_scene if signal.rates else 0.0
        if part > 0:
            seen = picture(list(signal.rates.values())) * self._slope(*signal.shape[1:3])
            shown = np.float32(1 - part) + np.float32(part) * seen
            added = added * signal.backend.tensor(shown[None])
        return signal.replace(signal.value + added)

    def _slope(self, height: int, width: int) -> NDArray[np.float32]:
        """How bright the room is across the picture, (H, W, 1)."""
        up = 1.0 - (np.arange(height)[:, None] + 0.5) / (height / 2)
        right = (np.arange(width)[None] + 0.5) / (width / 2) - 1.0
        bright = 1.0 + self.to_the_right * right + self.to_the_top * up
        return np.maximum(bright, 0.0)[..., None].astype(np.float32)


def picture(rates: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    """A scene in the light of all its lamps together, of mean 1 in each colour.

    Args:
        rates: what each lamp shows, (H, W, 3).
    """
    each = [rate / np.maximum(rate.mean(axis=(0, 1)), np.float32(1e-30)) for rate in rates]
    return np.asarray(np.mean(each, axis=0, dtype=np.float32))
