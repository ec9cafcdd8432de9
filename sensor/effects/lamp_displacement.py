"""Displaced lamp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import drjit as dr

from sensor.effect import Effect, Stage, parameter
from sensor.image_plane import constant, from_centre_px
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class LampDisplacement(Effect):
    """The lamp hangs some centimetres from where the model has it.

    A small lamp at l lights a plane at p with E = I cos(theta) / R^2 = I l_z / |l - p|^3. Moved by
    s, with d = 2 (l - p) . s / R^2 + s^2 / R^2, every pixel changes by

        E(l + s) / E(l) = (1 + s_z / l_z) (1 + d)^(-3/2):

    a smooth slope across the image, the same in all colours and frames. For a lamp straight ahead,
    moving it to the right changes the left as moving it to the left changes the right; pixel gains
    of equal variance have no slope at all. Lengths are those of a chart seen in the image's width.
    """

    name: ClassVar[str] = "lamp_displacement"
    stage: ClassVar[Stage] = Stage.LIGHTING
    position: ClassVar[int] = 30
    reference: ClassVar[str] = "photometric law of distance and cosine law for a point source"

    right_cm: float = parameter(
        3.0, unit="cm", minimum=-20.0, maximum=20.0, identity=0.0, doc="moved to the right"
    )
    up_cm: float = parameter(
        0.0, unit="cm", minimum=-20.0, maximum=20.0, identity=0.0, doc="moved up"
    )
    away_cm: float = parameter(
        0.0, unit="cm", minimum=-20.0, maximum=20.0, identity=0.0, doc="moved away from the chart"
    )
    lamp_right_cm: float = parameter(
        0.0,
        unit="cm",
        minimum=-200.0,
        maximum=200.0,
        stated=True,
        doc="lamp, assumed, right of the centre",
    )
    lamp_up_cm: float = parameter(
        40.0,
        unit="cm",
        minimum=-200.0,
        maximum=200.0,
        stated=True,
        doc="lamp, assumed, above the centre",
    )
    lamp_away_cm: float = parameter(
        45.0,
        unit="cm",
        minimum=25.0,
        maximum=1000.0,
        stated=True,
        doc="lamp, assumed, off the chart's plane",
    )
    field_width_cm: float = parameter(
        28.0,
        unit="cm",
        minimum=1.0,
        maximum=500.0,
        stated=True,
        doc="width of the chart that the image shows",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        cm_per_px = constant(signal, self.field_width_cm / signal.format.width)
        down, right = from_centre_px(signal)
        right_cm = constant(signal, self.lamp_right_cm) - right * cm_per_px
        up_cm = constant(signal, self.lamp_up_cm) + down * cm_per_px
        away_cm = constant(signal, self.lamp_away_cm)
        moved = [constant(signal, s) for s in (self.right_cm, self.up_cm, self.away_cm)]

        towards = right_cm * moved[0] + up_cm * moved[1] + away_cm * moved[2]
        length2 = moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2]
        distance2 = right_cm * right_cm + up_cm * up_cm + away_cm * away_cm
        stretch = 1.0 + (2.0 * towards + length2) / distance2
        ratio = (1.0 + moved[2] / away_cm) / (stretch * dr.sqrt(stretch))
        return signal.replace(signal.value * ratio)
