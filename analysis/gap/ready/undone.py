"""Where a camera that changes its output, or leaks, begins: first figures of frames with that
undone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from analysis.gap.camera.base import Base
from analysis.gap.camera.light import light_of
from analysis.gap.look.curve import powered
from analysis.gap.look.observe import observe
from analysis.gap.look.shots import stack_of
from analysis.gap.ready.color_matrix import matrix_of
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.hot_pixels import healed, leaks_of, longest_dark
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, black_of_frames
from sensor.frames import Frames


def unbent(setting: Setting, told: DirectReading) -> DirectReading:
    """A curve with where the camera begins in front of it: the base by moments of frames without
    it, under light as these show it where nobody stated any.

    A curve that is strong changes gain and noise from level to level, so that the base calibrated
    without it is no place to begin.

    Args:
        setting: the capture.
        told: the exponent of the curve.
    """
    exponent = told.hints["exponent"]
    assert isinstance(exponent, float), "a curve is the same in all colours"
    origin_dn = 0.0 if told.hints.get("about_black") == 0.0 else setting.black_dn
    straight = tuple(_through(f, 1.0 / exponent, origin_dn) for f in setting.key_frames)
    if setting.scenery.light.in_electrons:
        return dataclasses.replace(told, base=_by_moments_of(setting, straight))
    capture = dataclasses.replace(setting.capture, frames=straight)
    light = light_of(capture, {}, black_of_frames(straight))
    scenery = dataclasses.replace(setting.scenery, light=light)
    begun = dataclasses.replace(setting, scenery=scenery)
    return dataclasses.replace(told, base=_by_moments_of(begun, straight), scenery=scenery)


def unmixed(setting: Setting, told: DirectReading) -> Base:
    """The base by moments of frames without the matrix that they tell, for the same reason.

    Args:
        setting: the capture.
        told: the parts of the matrix.
    """
    inverse = np.linalg.inv(matrix_of(told)).astype(np.float32)
    black = np.float32(setting.black_dn)

    def through(frames: Frames) -> Frames:
        dn = np.empty(frames.dn.shape, dtype=frames.dn.dtype)
        for k, codes in enumerate(frames.dn):
            straight = (codes - black) @ inverse.T + black
            dn[k] = np.clip(np.round(straight), 0, frames.top_dn)
        return dataclasses.replace(frames, dn=dn)

    return _by_moments_of(setting, [through(f) for f in setting.key_frames])


def without_leaks(setting: Setting) -> Base:
    """The base by moments of frames without the photosites that leak, which a calibration takes for
    a fixed pattern.

    Args:
        setting: the capture, of which a dark shot shows them.
    """
    dark = longest_dark(setting)
    assert dark is not None, "leaks are told by a dark shot"
    leaks = [(one, leaks_of(dark, one).where) for one in setting.scenery.view.lattices]
    return _by_moments_of(setting, [healed(f, leaks) for f in setting.key_frames])


def _by_moments_of(setting: Setting, frames: Sequence[Frames]) -> Base:
    """The base by moments of other frames of the same shots."""
    seen = observe((stack_of(f, setting.plan) for f in frames), setting.scenery.view)
    straight = dataclasses.replace(setting, seen=seen, black_dn=black_of_frames(frames))
    _, base = by_moments(straight)
    return base


def _through(frames: Frames, exponent: float, origin_dn: float) -> Frames:
    """Frames with all that a code is above an origin raised to a power of its part of the range, as
    whole codes again.
    """
    codes = powered(np.arange(frames.top_dn + 1.0), frames.top_dn, origin_dn, exponent)
    codes = np.clip(np.round(codes), 0, frames.top_dn)
    return dataclasses.replace(frames, dn=codes.astype(frames.dn.dtype)[frames.dn])
