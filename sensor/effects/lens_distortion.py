"""Lens distortion beyond the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant, from_centre_px, half_diagonal_px
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.unresolved import moved, unresolved_edges


@dataclass(frozen=True, kw_only=True)
class LensDistortion(Effect):
    """The scale of the picture changes from the centre to the corners: straight lines bend.

        rate'(p) = rate(p (1 + k1 r^2)),    p from the centre, r = 1 in the corners

    Positive k1 is a barrel, negative a cushion. A vertical line at x is drawn where
    x' (1 + k1 r'^2) = x: close to the middle line more than at its ends, alike in all colours. A
    blur of equal strength moves no line. Light from outside the image is taken as that at its edge.
    """

    name: ClassVar[str] = "lens_distortion"
    stage: ClassVar[Stage] = Stage.OPTICS
    position: ClassVar[int] = 20
    reference: ClassVar[str] = (
        "Brown, Photogrammetric Engineering 37, 855 (1971), first radial term"
    )

    k1: float = parameter(
        0.01,
        unit="1",
        minimum=-0.2,
        maximum=0.2,
        identity=0.0,
        doc="relative change of scale in the corners",
    )
    unresolved: float = unresolved_edges()

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        down, right = from_centre_px(signal)
        scale = constant(signal, 1.0 / half_diagonal_px(signal.format))
        y, x = down * scale, right * scale
        stretch = 1.0 + constant(signal, self.k1) * (y * y + x * x)
        return moved(signal, stream, down * stretch, right * stretch, self.unresolved)
