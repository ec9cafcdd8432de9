"""Brightness as video knows it: Y = 0.299 R + 0.587 G + 0.114 B in every pixel."""

from __future__ import annotations

from sensor.errors import CameraError
from sensor.signal import Signal

RED, GREEN, BLUE = 0.299, 0.587, 0.114
"""Weights of luma in ITU-R BT.601."""


def need_colours(signal: Signal, effect: str) -> None:
    """Refuse pixels of one value, for the effect that asks.

    Raises:
        CameraError: where a pixel has one value only.
    """
    if not signal.coloured:
        raise CameraError(
            f"effect '{effect}' on pixels of one value",
            "expected three colours in every pixel",
            "add the effect 'demosaic' (with pixels rgb8), or remove this one",
        )
