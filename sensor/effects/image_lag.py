"""Image lag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.effect import Effect, Stage, parameter
from sensor.film import Film
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
        f, last = self.fraction, self.history_frames
        weights = [f**back * (1.0 - f if back < last else 1.0) for back in range(last + 1)]
        return signal.replace(Film.of(signal).filtered(weights))
