"""Lamp of another colour."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import per_colour
from sensor.signal import Signal
from sensor.stream import Stream

SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7
"""h c / k, CODATA 2018."""

EFFECTIVE_NM = Colours(R=610.0, G=530.0, B=460.0)
"""Maxima of the filters of a Sony interline CCD: those of scenes/data/surrogate.csv."""


@dataclass(frozen=True, kw_only=True)
class LampSpectrumError(Effect):
    """The lamp burns hotter or cooler than its spectrum in the model: its colours tilt.

    With Planck's law at the effective wavelength of each filter, P(T) = 1 / (exp(c2 / (w T)) - 1),
    and the level set so that green stays (as one adjusts a lamp to a grey card),

        gain_c = [P_c(T0 + shift) / P_c(T0)] / [P_G(T0 + shift) / P_G(T0)].

    Green does not move, red and blue move against each other, log gains in the ratio of their
    differences of 1/wavelength from green. It is a change of light: variance still equals mean in
    electrons, where white balance after the converter scales the noise with the signal. Nothing
    happens in the dark.
    """

    name: ClassVar[str] = "lamp_spectrum_error"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 40
    reference: ClassVar[str] = "Planck's law; CIE 15:2018, illuminant A for the nominal 2856 K"

    shift_k: float = parameter(
        150.0,
        unit="K",
        minimum=-800.0,
        maximum=800.0,
        identity=0.0,
        doc="colour temperature of the lamp minus the nominal one",
    )
    nominal_k: float = parameter(
        2856.0, unit="K", minimum=2000.0, maximum=7000.0, doc="nominal colour temperature"
    )

    @property
    def gains(self) -> Colours:
        """Change of each colour relative to green."""
        before, after = self.nominal_k, self.nominal_k + self.shift_k

        def change(nm: float) -> float:
            c = SECOND_RADIATION_CONSTANT_NM_K / nm
            return math.expm1(c / before) / math.expm1(c / after)

        changes = EFFECTIVE_NM.map(change)
        return changes.map(lambda figure: figure / changes.G)

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.replace(signal.value * per_colour(signal, self.gains))
