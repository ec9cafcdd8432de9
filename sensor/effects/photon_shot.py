"""Photon shot noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class PhotonShot(Effect):
    """Charge comes in whole electrons: a Poisson count of the mean, in every frame anew.

    Variance equals mean. The mean holds light and dark charge together, so the shot noise of both
    is drawn at once: the sum of two Poisson counts is a Poisson count of the summed mean.
    """

    name: ClassVar[str] = "photon_shot"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 50
    base: ClassVar[bool] = True
    reference: ClassVar[str] = "Irie et al., equation (1) and Table II"

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return stream.counts(signal)
