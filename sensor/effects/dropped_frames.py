"""Dropped frames."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage, parameter
from sensor.film import Film
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class DroppedFrames(Effect):
    """A frame is lost on the cable, and the driver hands out the one before it again.

        y_k = y_(k-1) with probability p, else x_k

    A share p of the frames equals its predecessor in every pixel, which noise never does: a filter
    that correlates frames as strongly gives none that are equal. Frames repeat independently, so n
    repeats in a row have probability p^n; the chain is cut at the length that one frame in a
    million exceeds.
    """

    name: ClassVar[str] = "dropped_frames"
    stage: ClassVar[Stage] = Stage.TRANSPORT
    position: ClassVar[int] = 30
    repeats: ClassVar[bool] = True
    reference: ClassVar[str] = (
        "IIDC 1394-based Digital Camera Specification 1.31: isochronous packets are not sent again"
    )

    probability: float = parameter(
        0.05,
        unit="1",
        minimum=0.0,
        maximum=0.5,
        identity=0.0,
        starts=(0.25,),
        doc="probability that a frame repeats the one before",
    )

    @property
    def history_frames(self) -> int:  # type: ignore[override]
        """The most repeats in a row."""
        return math.ceil(math.log(1e-6) / math.log(self.probability)) if self.probability else 0

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.shape[0] == 1 or self.probability == 0:
            return signal.replace(signal.value)
        longest = self.history_frames
        start, stop = signal.frames.start - longest, signal.frames.stop
        longer = dataclasses.replace(stream, frames=range(start, stop))
        lost = np.asarray(longer.uniform(1).numpy()).ravel() < self.probability
        repeats = np.zeros(len(signal.frames), dtype=np.int64)
        unbroken = np.ones(len(signal.frames), dtype=bool)
        for back in range(longest):
            unbroken &= lost[longest - back : len(lost) - back]
            repeats += unbroken
        source = np.maximum(np.arange(len(signal.frames)) - repeats, 0)

        def shown(frame: Any) -> Any:
            index: Any = type(frame)
            return dr.gather(index, index(source.astype(np.uint32)), frame)

        return signal.replace(Film.of(signal).shown(shown))
