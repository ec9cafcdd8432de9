"""How large the disc is that makes a picture as soft as it is.

A camera is calibrated with a normal distribution of variance v along each axis, and a lens that is
focused elsewhere draws a disc of diameter D, whose variance is D^2 / 16. Beside the one the other
shows by its fourth moment alone, and no small step leads from here to there:

    D = 4 sqrt(v),    and the camera in focus
"""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.gap.camera.base import Base
from analysis.gap.ready.hints import DirectReading

LEAST_PX = 1.5
"""Diameter below which a disc within the pixels is a normal distribution."""


def soft(base: Base) -> DirectReading | None:
    """The disc that is as wide as the blur of a calibrated camera; None where that is sharp."""
    diameter_px = 4.0 * float(np.sqrt(base.blur_px2))
    if diameter_px < LEAST_PX:
        return None
    in_focus = dataclasses.replace(base, blur_px2=0.0)
    return DirectReading(hints={"diameter_px": diameter_px}, exact=False, base=in_focus)
