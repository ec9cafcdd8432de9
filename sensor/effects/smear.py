"""Smear of an interline sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage, parameter
from sensor.neighbours import Places, fetched, run_length
from sensor.planes import Planes
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class Smear(Effect):
    """Charge on its way down the vertical register collects stray light under its shield.

    Every packet passes every row of its column and stays transfer / H at each, so the mean charge
    added anywhere in a column x is

        leak (transfer / exposure) (1 / H) sum over the column of Q(y, x),

    the same above and below the light; its own shot noise is drawn in each pixel. The sum is of
    charge less the mean dark charge. No light, no smear.

    Consequence: dark rows of a bright column rise by the same amount on both sides, with temporal
    variance equal to that rise, and by twice as much relative to the picture when the exposure is
    halved. Veiling glare does not stop at the column, a column offset brings no noise.
    """

    name: ClassVar[str] = "smear"
    stage: ClassVar[Stage] = Stage.TRANSFER
    position: ClassVar[int] = 10
    reference: ClassVar[str] = (
        "Teranishi and Ishihara, Smear reduction in the interline CCD image sensor, "
        "IEEE Trans. Electron Devices 34, 1987"
    )

    leak_ratio: float = parameter(
        0.004,
        unit="1",
        minimum=0.0,
        maximum=0.1,
        identity=0.0,
        doc="light that gets under the shield, relative to that on the photosites",
    )
    transfer_s: float = parameter(
        1 / 15,
        unit="s",
        minimum=0.0,
        maximum=1.0,
        stated=True,
        doc="time to shift a whole frame out; 1/15 s at the camera's fastest rate. Frames show its "
        "product with the leak alone",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        shot = signal.shot
        if shot.dark or shot.exposure_s == 0.0:
            return signal.replace(+signal.value)
        share = self.leak_ratio * self.transfer_s / shot.exposure_s
        column_mean = dr.mean(signal.value, axis=1, mode="evaluated") - signal.clamp_e
        mean = share * dr.maximum(column_mean, 0.0).array
        dr.eval(mean)
        arrays, width = signal.backend.arrays, signal.shape[2]
        places = Places(arrays, signal.shape, run_length(arrays, width))
        run = (places.frame * width + places.first) // places.length
        added = tuple(fetched(mean, run, places.length))
        leaked = Planes(colours=(added,), shape=signal.shape, arrays=arrays)
        known = signal.replace(leaked, least=float(np.min(mean.numpy())))
        return signal.pointwise(lambda e, leak: e + leak, stream.counts(known).numbers)
