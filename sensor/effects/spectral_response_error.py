"""Colour responses that differ from the assumed ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.neighbours import Neighbours, interleaved
from sensor.signal import Quantity, Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class SpectralResponseError(Effect):
    """The filters pass other light than the table of spectral responses says.

    A colour c sees (1 + change_c) [(1 - 2 l_c) I_c + l_c (I_a + I_b)], where a and b are the two
    other colours and l_c is its leakage.

    Consequence: grey (three equal rates) stays grey, saturated colours move towards it, and the
    shot noise is that of the new mean: variance equals mean at every photosite, and the noise of
    neighbouring colours stays uncorrelated. A colour matrix after the noise gives the same means
    and smaller variance.
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
        return signal.replace(near.tensor(interleaved(planes), signal.shape))
