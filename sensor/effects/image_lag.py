"""Image lag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr
import numpy as np

from sensor.effect import Effect, Stage, parameter, switch
from sensor.film import Film
from sensor.limits import at_least
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

    Where each electron stays by chance, R_k is off by sqrt(f Q_k) e-, which the next frames give
    back: what is left of a Poisson process is one, so that frames of a steady scene have their
    whole variance and no memory again. Where a shot begins in the dark, R_-1 = 0 and the mean of
    frame k lacks f^(k+1) of itself: f of the first, f^2 of the second.
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
    by_chance: float = switch(
        0.0,
        starts=(0.0,),
        doc="0 for that share of all charge, 1 for each electron with that probability",
    )
    from_dark: float = switch(
        0.0,
        starts=(0.0,),
        doc="0 for steady light before the first frame, 1 for none",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        alike = signal.shape[0] == 1 and not (self.by_chance or self.from_dark)
        if alike or self.fraction == 0.0:
            return signal.replace(+signal.value)  # no frame differs from the one before it
        f, last = self.fraction, self.history_frames
        charge = signal.value
        if self.from_dark:
            there = np.array(stream.frames).reshape(-1, 1, 1) >= 0
            charge = charge * signal.backend.tensor(there.astype(np.float32))
        weights = [f**back * (1.0 - f if back < last else 1.0) for back in range(last + 1)]
        kept = Film.of(signal.replace(charge)).filtered(weights)
        if not self.by_chance:
            return signal.replace(kept)
        noise = stream.normal(*signal.shape[1:])
        off = dr.sqrt(f * at_least(charge, 0.0)) * noise
        # taken from its frame, and given back by those after it
        given = [-1.0, *(f**back * (1.0 - f if back < last - 1 else 1.0) for back in range(last))]
        back = Film.of(signal.replace(off)).filtered(given)
        return signal.replace(signal.replace(kept).value + signal.replace(back).value)
