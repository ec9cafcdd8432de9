"""Image lag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class ImageLag(Effect):
    """Not all charge leaves the photodiode; what stays behind comes out with later frames.

    Out_k = (1 - f)(Q_k + R_(k-1)), R_k = f (Q_k + R_(k-1)): a share f of what is there stays.
    Written out, Out_k = (1 - f) sum of f^j Q_(k-j); the sum ends at j = 4, whose weight takes in
    the rest, at most 1e-4. The light is taken as steady before the first frame.

    Consequence: the mean of a steady scene stays, the temporal variance falls to
    (1 - f) / (1 + f) of itself, and frames correlate as f^lag in time while pixels do not
    correlate in space. Independent noise has no memory.
    """

    name: ClassVar[str] = "image_lag"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 80
    history_frames: ClassVar[int] = 4
    reference: ClassVar[str] = (
        "Teranishi et al., No image lag photodiode structure in the interline CCD image sensor, "
        "IEDM 1982"
    )

    fraction: float = parameter(
        0.03,
        unit="1",
        minimum=0.0,
        maximum=0.1,
        identity=0.0,
        doc="share of the charge that stays behind at each readout",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if signal.shape[0] == 1 or self.fraction == 0.0:
            return signal.replace(+signal.value)  # no frame differs from the one before it
        charge = signal.value.array
        dr.eval(charge)
        lane = dr.arange(dr.uint32_array_t(type(charge)), dr.width(charge))
        frame_size = dr.width(charge) // signal.shape[0]
        f, last = self.fraction, self.history_frames
        total = (1.0 - f) * charge
        for back in range(1, last + 1):
            weight = f**back * (1.0 - f if back < last else 1.0)
            # frames earlier than the batch only feed frames that the camera cuts off
            earlier = dr.select(lane >= back * frame_size, lane - back * frame_size, lane)
            total = total + weight * dr.gather(type(charge), charge, earlier)
        return signal.replace(type(signal.value)(total, signal.shape))
