"""What a file says of its frames, beside the pixels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Told:
    """What stands in a file's header; None where it says nothing.

    Attributes:
        where: the kind of header, as in "EXIF".
        exposure_s, temperature_c: of the frames.
        camera: its model.
        bits: significant bits of a sample.
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1).
        conversion: what was done to the stored samples to make them pixels, if anything.
    """

    where: str = "header"
    exposure_s: float | None = None
    temperature_c: float | None = None
    camera: str | None = None
    bits: int | None = None
    cfa: str | None = None
    conversion: str | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Roll:
    """The frames of one file, in their order, one at a time.

    Attributes:
        told: what the header says.
        frames: each (H, W) or (H, W, 3).
        several: whether the file can hold more than one frame.
    """

    told: Told
    frames: Iterator[NDArray[Any]]
    several: bool


def positive(value: Any) -> float | None:
    """A header's number, where it is one that can be an exposure."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return number if math.isfinite(number) and number > 0 else None
