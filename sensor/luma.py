"""Brightness as video knows it: one weighted sum of red, green and blue per pixel."""

from __future__ import annotations

from typing import Any

import drjit as dr

from sensor.errors import CameraError
from sensor.signal import Signal

RED, GREEN, BLUE = 0.299, 0.587, 0.114
"""Weights of luma in ITU-R BT.601."""


def luma(signal: Signal, effect: str) -> Any:
    """Luma of every pixel of an image with three colours: a tensor (f, H, W).

    Args:
        signal: the image.
        effect: who asks, for the message.

    Raises:
        CameraError: where a pixel has one value only.
    """
    if not signal.coloured:
        raise CameraError(
            f"effect '{effect}' on pixels of one value",
            "expected three colours in every pixel",
            "add the effect 'demosaic' (with pixels rgb8), or remove this one",
        )
    flat = signal.value.array
    dr.eval(flat)
    index = dr.uint32_array_t(type(flat))
    first = dr.arange(index, dr.width(flat) // 3) * 3
    red, green, blue = (dr.gather(type(flat), flat, first + k) for k in range(3))
    return type(signal.value)(RED * red + GREEN * green + BLUE * blue, signal.shape[:3])
