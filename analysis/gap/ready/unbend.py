"""Where a camera that bends its output begins: first figures of frames with the curve undone."""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.gap.camera.base import Base
from analysis.gap.look.observe import observe
from analysis.gap.look.shots import stack_of
from analysis.gap.ready.hints import Told
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, black_of_frames
from sensor.frames import Frames


def unbent(setting: Setting, told: Told) -> Base:
    """The base by moments of frames without the curve that they tell.

    A curve that is strong changes gain and noise from level to level, so that the base calibrated
    without it is no place to begin.

    Args:
        setting: the capture.
        told: the exponent of the curve.
    """
    exponent = told.hints["exponent"]
    assert isinstance(exponent, float), "a curve is the same in all colours"
    inverse = 1.0 / exponent
    frames = [_through(f, inverse) for f in setting.key_frames]
    seen = observe((stack_of(f, setting.plan) for f in frames), setting.scenery.view)
    straight = dataclasses.replace(setting, seen=seen, black_dn=black_of_frames(frames))
    _, base = by_moments(straight)
    return base


def _through(frames: Frames, exponent: float) -> Frames:
    """Frames with every code raised to a power of its part of the range, as whole codes again."""
    top = frames.top_dn
    codes = np.round(top * (np.arange(top + 1) / top) ** exponent)
    return dataclasses.replace(frames, dn=codes.astype(frames.dn.dtype)[frames.dn])
