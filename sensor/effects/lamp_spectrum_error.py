"""Lamp of another colour."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.colour_slopes import EFFECTIVE_NM, WIDTH_NM, log_slopes_per_nm
from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.filament import has_filament
from sensor.image_plane import per_colour
from sensor.signal import Signal
from sensor.stream import Stream

SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7
"""h c / k, CODATA 2018."""

ALL, WITH_FILAMENT, WITHOUT = 0.0, 1.0, 2.0
"""Lamps that burn so. A share of the shift, as `filament` of a drift is, cannot say that filaments
alone do."""


@dataclass(frozen=True, kw_only=True)
class LampSpectrumError(Effect):
    """The lamp burns hotter or cooler than its spectrum in the model: its colours tilt.

    With Planck's law at the effective wavelength of each filter, P(T) = 1 / (exp(c2 / (w T)) - 1),
    and the level set so that green stays (as one adjusts a lamp to a grey card),

        gain_c = [P_c(T0 + shift) / P_c(T0)] / [P_G(T0 + shift) / P_G(T0)] exp(k_c v_c s_c),
        k_c = c2 / w_c^2 (1 / (T0 + shift) - 1 / T0).

    Of a grey card green does not move, red and blue move against each other, log gains in the ratio
    of their differences of 1/wavelength from green. What is coloured reflects more at one end of a
    filter than at the other, and the lamp has changed by k per nm there: of a filter of variance v
    and a reflectance whose logarithm has the slope s that is k v s. The slope is told by the next
    colours, less that of the whole scene, which the level of the lamp takes up. It is a change of
    light: variance still equals mean in electrons, where white balance after the converter scales
    the noise with the signal. Nothing happens in the dark.
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
        2856.0,
        unit="K",
        minimum=2000.0,
        maximum=7000.0,
        stated=True,
        doc="nominal colour temperature, assumed: light tells shift / nominal^2",
    )
    lamps: float = parameter(
        ALL,
        unit="1",
        minimum=ALL,
        maximum=WITHOUT,
        whole=True,
        starts=(ALL, WITH_FILAMENT, WITHOUT),
        doc="which lamps: 0 all, 1 those with a filament by their names, 2 those without",
    )

    @property
    def gains(self) -> Colours:
        """Change of each colour of a grey card relative to green."""
        before, after = self.nominal_k, self.nominal_k + self.shift_k

        def change(nm: float) -> float:
            c = SECOND_RADIATION_CONSTANT_NM_K / nm
            return math.expm1(c / before) / math.expm1(c / after)

        changes = EFFECTIVE_NM.map(change)
        return changes.map(lambda figure: figure / changes.G)

    @property
    def of_slopes_nm(self) -> Colours:
        """Change of the logarithm of each colour by the slope of a reflectance, k v in nm."""
        cooler_per_k = 1.0 / (self.nominal_k + self.shift_k) - 1.0 / self.nominal_k
        per_nm = EFFECTIVE_NM.map(
            lambda nm: SECOND_RADIATION_CONSTANT_NM_K / (nm * nm) * cooler_per_k
        )
        return per_nm.map(lambda k, width: k * width * width, WIDTH_NM)

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        another = self.lamps != ALL and has_filament(signal.shot) != (self.lamps == WITH_FILAMENT)
        if signal.shot.dark or another:
            return signal.replace(signal.value)
        gain = per_colour(signal, self.gains) * dr.exp(
            per_colour(signal, self.of_slopes_nm) * log_slopes_per_nm(signal)
        )
        return signal.replace(signal.value * gain)
