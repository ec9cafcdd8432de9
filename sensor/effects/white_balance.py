"""Digital white balance."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter, switch
from sensor.errors import CameraError
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class WhiteBalance(Effect):
    """Red and blue are multiplied so that grey looks grey under the lamp.

        DN'_c = o + k_c (DN_c - o),    k_G = 1

    where o is the black level, or code 0 in a program that knows of none.
    Signal and noise are multiplied alike: the mean of a channel grows by k and its variance by
    k^2, so its apparent conversion in DN/e- is k times the true one, where more light of that
    colour would leave the conversion as it is. Calibration absorbs it as a gain. Whole codes of a
    mosaic that are multiplied leave a comb of empty and double codes; a demosaicer says by its own
    arithmetic whether what comes from it is whole.
    """

    name: ClassVar[str] = "white_balance"
    stage: ClassVar[Stage] = Stage.PROCESSING
    position: ClassVar[int] = 20
    reference: ClassVar[str] = "IIDC 1394-based Digital Camera Specification 1.31, WHITE_BALANCE"

    red_gain: float = parameter(
        1.15,
        unit="1",
        minimum=0.1,
        maximum=8.0,
        identity=1.0,
        doc="factor of red",
    )
    blue_gain: float = parameter(
        1.25,
        unit="1",
        minimum=0.1,
        maximum=8.0,
        identity=1.0,
        doc="factor of blue",
    )
    about_black: float = switch(
        1.0,
        starts=(1.0,),
        doc="1 where the black level stays as it is, 0 where it is multiplied too",
    )
    whole_codes: float = switch(
        0.0,
        starts=(0.0,),
        doc="1 where a mosaic has been rounded to whole codes before",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        if not signal.coloured and len(set(signal.format.cfa)) == 1:
            raise CameraError(
                "effect 'white_balance' in a camera without colour filters",
                "expected a mosaic or a demosaicer",
                "remove the effect",
            )
        origin = signal.format.black_dn if self.about_black else 0.0
        if not signal.coloured:
            gains = Colours(R=self.red_gain - 1.0, G=0.0, B=self.blue_gain - 1.0)
            change = signal.by_colour(gains)
            value = dr.round(signal.value) if self.whole_codes else signal.value
            return signal.replace(value + change * (value - origin))
        planes, number = signal.planes, dr.array_t(signal.backend.arrays.TensorXf)
        red, blue = (dr.opaque(number, gain - 1.0) for gain in (self.red_gain, self.blue_gain))
        colours = (
            tuple(part + red * (part - origin) for part in planes.colours[0]),
            planes.colours[1],
            tuple(part + blue * (part - origin) for part in planes.colours[2]),
        )
        return signal.replace(dataclasses.replace(planes, colours=colours))
