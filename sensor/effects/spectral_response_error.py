"""Colour responses that differ from the assumed ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.colour_slopes import Weights, log_slopes_per_nm
from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import per_colour
from sensor.neighbours import Neighbours, interleaved
from sensor.signal import Quantity, Signal
from sensor.stream import Stream

AT_THE_FILTERS: Weights = ((0.75, -0.45), (0.24, 0.69), (-0.54, 0.99))
"""Slopes at the filters by those between the colours, nearly those of a parabola through all three:
least squares of what a ColorChecker gains by filters that move, under Planck's 2856 and 6500 K and
CIE's FL1, FL2 and FL7 (`tests/test_lamp_spectrum.py` holds them to it)."""


@dataclass(frozen=True, kw_only=True)
class SpectralResponseError(Effect):
    """The filters pass other light than the table of spectral responses says.

    A colour c sees (1 + change_c) [(1 - 2 l_c) I_c + l_c (I_a + I_b)] exp(d_c s_c), where a and b
    are the two other colours, l_c is its leakage, and d_c the shift of its filter towards the red:
    by that it sees more of what has a slope s_c of its logarithm in the filter. Slopes are told by
    the three colours, less that of the whole scene, which the response as a whole takes up.

    Consequence: by leakage grey (three equal rates) stays grey and saturated colours move towards
    it; by a shift the scene's mean colour stays, and what is redder than that gains. The shot noise
    is that of the new mean: variance equals mean at every photosite, and the noise of neighbouring
    colours stays uncorrelated. A colour matrix after the noise gives the same means and smaller
    variance.
    """

    name: ClassVar[str] = "spectral_response_error"
    stage: ClassVar[Stage] = Stage.PHOTOSITE
    position: ClassVar[int] = 5
    quantity_override: ClassVar[Quantity | None] = Quantity.RATE
    reference: ClassVar[str] = (
        "Jiang et al., What is the space of spectral sensitivity functions for digital color "
        "cameras?, WACV 2013: how responses differ between cameras"
    )

    leakage: float | Colours = parameter(
        0.04,
        unit="1",
        minimum=0.0,
        maximum=1 / 3,
        identity=0.0,
        per_colour=True,
        doc="share of a colour's response that really is each other colour's",
    )
    shift_nm: float | Colours = parameter(
        0.0,
        unit="nm",
        minimum=-10.0,
        maximum=10.0,
        identity=0.0,
        per_colour=True,
        doc="shift of a colour's filter towards the red",
    )
    response_change: float | Colours = parameter(
        0.0,
        unit="1",
        minimum=-0.9,
        maximum=2.0,
        identity=0.0,
        stated=True,
        per_colour=True,
        doc="relative change of a colour's response as a whole",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        near = Neighbours(signal)
        red, green, blue = (near.flat_at(0, 0, colour) for colour in range(3))
        leak, change = Colours.of(self.leakage), Colours.of(self.response_change)
        planes = [
            (1.0 + g) * ((1.0 - 2.0 * share) * own + share * (first + second))
            for g, share, own, first, second in zip(
                change, leak, (red, green, blue), (green, blue, red), (blue, red, green),
                strict=True,
            )
        ]  # fmt: skip
        seen = near.tensor(interleaved(planes), signal.shape)
        shift_nm = Colours.of(self.shift_nm)
        if any(shift_nm):
            seen = seen * dr.exp(
                per_colour(signal, shift_nm) * log_slopes_per_nm(signal, AT_THE_FILTERS)
            )
        return signal.replace(seen)
