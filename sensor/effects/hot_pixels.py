"""Hot pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.thermal import darkness_s


@dataclass(frozen=True, kw_only=True)
class HotPixels(Effect):
    """A few photosites with a defect in the silicon leak far more charge than the others.

    Each photosite of the body is hot with probability `density`; a hot one adds
    rate x 2^((T - 29 degC) / 8 degC) x exposure x E electrons in the mean, E exponential of mean 1.

    Consequence: the same few photosites stand out in every frame and shot, in proportion to the
    exposure, each with a temporal variance equal to its excess. Heavy-tailed noise of equal
    variance moves from frame to frame.
    """

    name: ClassVar[str] = "hot_pixels"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 34
    product: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "Leung, Chapman, Koren and Koren, Characterization of gain-enhanced in-field defects in "
        "digital imagers, IEEE DFT 2009"
    )

    density: float = parameter(
        0.002,
        unit="1",
        minimum=0.0,
        maximum=0.1,
        identity=0.0,
        doc="share of the photosites that are hot",
    )
    rate_e_per_s: float = parameter(
        40_000.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e6,
        identity=0.0,
        doc="mean leakage of a hot photosite at 29 degC",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        mean_e = self.rate_e_per_s * darkness_s(signal.shot)
        shape = signal.shape[1:]
        hot = stream.body.uniform(*shape, use="where") < self.density
        excess = -mean_e * dr.log(1.0 - stream.body.uniform(*shape, use="rate"))
        return signal.replace(signal.value + dr.select(hot, excess, 0.0))
