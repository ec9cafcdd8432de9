"""Where a camera in a lit room begins: what darks gather by colour is light."""

from __future__ import annotations

import dataclasses

from analysis.gap.ready.hints import Told
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting
from sensor.colours import CHANNELS, Colours

COLOURED = 0.15
"""Difference between the colours, as a part of their mean, that gains by moments do not have."""

SEEN_DN = 0.3
"""What the longest dark must gather for its colour to be told."""


def lit_room(setting: Setting) -> Told | None:
    """Light of a colour in the darks, and the base by moments without dark current.

    Dark current is the same under every filter. Where darks gather more under one, a base that
    takes the light for dark current makes up for it in its gains, and is no place to begin.

    Args:
        setting: the capture.
    """
    if len(setting.seen.channels) == 1:
        return None
    dark, base = by_moments(setting)
    longest_s = max((s.exposure_s for s in setting.scenery.shots if s.dark), default=0.0)
    rate = dark.mean_dn_per_s / base.gain_dn_per_e
    if (dark.mean_dn_per_s * longest_s).max() < SEEN_DN or rate.min() < 0:
        return None
    if rate.max() - rate.min() < COLOURED * rate.mean():
        return None
    light = Colours(**dict(zip(CHANNELS, map(float, rate), strict=True)))
    return Told(
        hints={"rate_e_per_s": light, "share_in_dark": 1.0},
        exact=False,
        base=dataclasses.replace(base, dark_e_per_s=0.0, shown_e_per_s=0.0),
    )
