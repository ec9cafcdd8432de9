"""Veiling glare."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy import ndimage

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant, scene_mean
from sensor.signal import Signal
from sensor.stream import Stream

EVENLY = 3.0
"""Reach, in heights of the image, from which light goes everywhere alike."""

ROWS = 64
"""Rows of the grid on which light is spread; its least reach is three of them."""


@dataclass(frozen=True, kw_only=True)
class VeilingGlare(Effect):
    """Lens surfaces and barrel scatter a part of all light far over the image.

        rate' = (1 - v) rate + v veil    by colour

    The veil is the mean over the image where light is scattered evenly, and a mean with normal
    weights of standard deviation `reach` about each pixel where it stays in the neighbourhood; what
    would leave the image is thrown back. No light is lost. A black panel anywhere rises to v times
    the mean of the scene, and follows the scene's mean, not its neighbours': a blur that takes as
    much contrast from the edges leaves the middle of a panel alone, and ambient light does not
    follow the lamp.
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

    reach: float = parameter(
        3.0,
        unit="1",
        minimum=0.05,
        maximum=3.0,
        starts=(3.0, 0.45, 0.2),
        doc="how far it goes, as a standard deviation in heights of the image; 3 is evenly",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        fraction = constant(signal, self.fraction)
        veil = scene_mean(signal) if self.reach >= EVENLY else _spread(signal, self.reach)
        return signal.replace((1.0 - fraction) * signal.value + fraction * veil)


def _spread(signal: Signal, reach: float) -> Any:
    """The light about each pixel, (f, H, W, 3): on a coarse grid, as nothing in it is fine."""
    import cv2

    frames = np.asarray(signal.value.numpy(), dtype=np.float32).reshape(signal.shape)
    height, width = signal.shape[1:3]
    rows = min(height, ROWS)
    columns = max(1, round(width * rows / height))
    soft = []
    for frame in frames:
        coarse = cv2.resize(frame, (columns, rows), interpolation=cv2.INTER_AREA)
        veil = ndimage.gaussian_filter(coarse, (reach * rows, reach * rows, 0), mode="reflect")
        soft.append(cv2.resize(veil, (width, height), interpolation=cv2.INTER_LINEAR))
    return signal.backend.tensor(np.array(soft))
