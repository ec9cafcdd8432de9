"""Specular highlight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant, from_centre_px, scene_mean
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class SpecularGlare(Effect):
    """A slightly glossy chart mirrors the lamp into a soft patch of the image.

    To every pixel comes the light of a Gaussian lobe, in the lamp's colour and in proportion to its
    level; the scene's mean stands for both:

        rate' = rate + strength mean(rate) exp(-rho^2 / (2 sigma^2)),  rho from the patch's centre.

    The light added is 2 pi sigma^2 strength mean(rate), whatever lies below it: black panels gain
    as much as white ones, and the patch keeps its place and shape in every frame and level. An even
    veil of the same light has no patch, independent noise adds none.
    """

    name: ClassVar[str] = "specular_glare"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 50
    reference: ClassVar[str] = "Phong, CACM 18, 311 (1975), its lobe in the Gaussian limit"

    strength: float = parameter(
        0.2,
        unit="1",
        minimum=0.0,
        maximum=10.0,
        identity=0.0,
        doc="light at the peak of the patch, relative to the mean of the scene",
    )
    across: float = parameter(
        0.65, unit="1", minimum=0.0, maximum=1.0, doc="centre, as a part of the width from the left"
    )
    below: float = parameter(
        0.35, unit="1", minimum=0.0, maximum=1.0, doc="centre, as a part of the height from the top"
    )
    sigma_px: float = parameter(
        30.0, unit="px", minimum=2.0, maximum=200.0, doc="standard deviation of the lobe"
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        height, width = signal.shape[1:3]
        down, right = from_centre_px(signal)
        figures = ((self.below - 0.5) * height, (self.across - 0.5) * width, 1.0 / self.sigma_px)
        y, x, scale = (constant(signal, figure) for figure in figures)
        y, x = (down - y) * scale, (right - x) * scale
        lobe = dr.exp(-0.5 * y * y) * dr.exp(-0.5 * x * x)
        peak = constant(signal, self.strength) * scene_mean(signal)
        return signal.replace(signal.value + peak * lobe)
