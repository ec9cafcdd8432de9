"""Black-level offset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sensor.colours import Colours
from sensor.effect import Effect, Stage, parameter
from sensor.signal import Signal
from sensor.stream import Stream


@dataclass(frozen=True, kw_only=True)
class BlackLevelOffset(Effect):
    """The clamp settles beside its nominal level, and everything is read with that error.

        e(k, y, x) += offset

    The mean moves by gain x offset in the dark and in the light, and no variance changes: light of
    the same mean would bring its shot noise along. Calibration absorbs it as a black level.
    """

    name: ClassVar[str] = "black_level_offset"
    stage: ClassVar[Stage] = Stage.READOUT
    position: ClassVar[int] = 60
    reference: ClassVar[str] = (
        "EMVA 1288 release 4: the dark signal mu_y.dark of the linear camera model"
    )

    offset_e: float | Colours = parameter(
        66.0,
        unit="e-",
        minimum=-10000.0,
        maximum=10000.0,
        identity=0.0,
        per_colour=True,
        doc="black level above its nominal value, as charge; 66 e- are 1 DN of a 1/4-inch CCD",
    )

    def apply(self, signal: Signal, stream: Stream) -> Signal:
        return signal.pointwise(lambda charge_e, offset_e: charge_e + offset_e, self.offset_e)
