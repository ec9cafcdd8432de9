"""Specular highlight."""

from __future__ import annotations

import math
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

    A lamp that is longer than wide, or a chart that is seen from the side, makes it an ellipse with
    sigma sqrt(l) along and sigma / sqrt(l) across its longer axis.
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
    longer: float = parameter(
        1.0,
        unit="1",
        minimum=1.0,
        maximum=8.0,
        stated=True,
        doc="length of the patch over its width",
    )
    slant_deg: float = parameter(
        0.0,
        unit="deg",
        minimum=-90.0,
        maximum=90.0,
        stated=True,
        doc="from a row, downwards, to the longer axis",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        height, width = signal.shape[1:3]
        down, right = from_centre_px(signal)
        slant, stretch = math.radians(self.slant_deg), math.sqrt(self.longer)
        along, across = 1.0 / (self.sigma_px * stretch), stretch / self.sigma_px
        y = down - constant(signal, (self.below - 0.5) * height)
        x = right - constant(signal, (self.across - 0.5) * width)
        lobe = 1.0
        for by_x, by_y in (
            (math.cos(slant) * along, math.sin(slant) * along),
            (-math.sin(slant) * across, math.cos(slant) * across),
        ):
            off = x * constant(signal, by_x) + y * constant(signal, by_y)
            lobe = lobe * dr.exp(-0.5 * off * off)
        peak = constant(signal, self.strength) * scene_mean(signal)
        return signal.replace(signal.value + peak * lobe)
