"""Veiling glare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class VeilingGlare(Effect):
    """Lens surfaces and barrel scatter a part of all light evenly over the image.

        rate' = (1 - v) rate + v mean(rate)    by colour, mean over the image

    No light is lost. A black panel anywhere rises to v times the mean of the scene, and follows the
    scene's mean, not its neighbours': a blur that takes as much contrast from the edges leaves the
    middle of a panel alone, and ambient light does not follow the lamp.
    """

    name: ClassVar[str] = "veiling_glare"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 60
    reference: ClassVar[str] = "ISO 9358:1994, veiling glare index"

    fraction: float = parameter(
        0.03,
        unit="1",
        minimum=0.0,
        maximum=0.5,
        identity=0.0,
        doc="part of the light that is scattered: 0.01 to 0.05 in small lenses",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        mean = dr.mean(dr.mean(signal.value, axis=2), axis=1)  # rows first: float32 sums stay short
        veil = type(mean)(mean.array, (signal.shape[0], 1, 1, 3))
        fraction = constant(signal, self.fraction)
        return signal.replace((1.0 - fraction) * signal.value + fraction * veil)
