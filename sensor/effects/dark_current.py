"""Dark current that nothing compensates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream
from sensor.thermal import DOUBLING_C, darkness_s


@dataclass(frozen=True, kw_only=True)
class DarkCurrent(Effect):
    """Thermal electrons that differ from photosite to photosite and stay in the frames.

    d(y, x) = mean 2^((T - 29 degC) / doubling) t exp(s n - s^2 / 2), n a standard normal number of
    the camera body and s^2 = ln(1 + spread^2): a log-normal pattern of the given mean and relative
    standard deviation. T is the shot's temperature; 29 degC where it tells none.

    Consequence: in the dark the spatial pattern grows in proportion to the exposure and has
    skewness spread (3 + spread^2), and the temporal variance of a photosite equals its own mean,
    because the charge is drawn. Offsets and noise of equal variance do neither.
    """

    name: ClassVar[str] = "dark_current"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 32
    reference: ClassVar[str] = (
        "Baer, A model for dark current characterization and simulation, Proc. SPIE 6068, 2006; "
        "EMVA 1288 release 4, section 7"
    )

    mean_e_per_s: float = parameter(
        3000.0,
        unit="e-/s",
        minimum=0.0,
        maximum=1e5,
        identity=0.0,
        doc="mean over the photosites at 29 degC",
    )
    spread: float = parameter(
        0.5,
        unit="1",
        minimum=0.0,
        maximum=3.0,
        doc="standard deviation over the photosites, relative to the mean",
    )
    doubling_c: float = parameter(
        DOUBLING_C,
        unit="degC",
        minimum=4.0,
        maximum=15.0,
        doc="rise of temperature that doubles it",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        mean_e = self.mean_e_per_s * darkness_s(signal.shot, self.doubling_c)
        s = math.sqrt(math.log1p(self.spread**2))
        pattern = stream.body.normal(*signal.shape[1:])
        return signal.replace(signal.value + mean_e * dr.exp(s * pattern - s * s / 2))
