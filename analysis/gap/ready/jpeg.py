"""Where a camera begins whose darks a codec has emptied.

A coefficient that stays within half a step of none is none in every frame, so that darks lose their
noise, their pattern and up to half a step of their mean. Lit shots have coefficients of all sizes:
their means lie on the line that points to the black level, and green, of which luminance keeps
most, has most nearly the gain that it had.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.calibrate.darks import black_by_light
from analysis.gap.camera.base import Base, channels_alike
from analysis.gap.ready.setting import Setting


def behind_blocks(setting: Setting, base: Base) -> Base | None:
    """The base with the black level that lit shots point to, the gain of green in all channels, and
    noise and offsets in darks as large as those of rounding; None where lit shots do not tell a
    black level.

    Args:
        setting: the capture.
        base: calibrated without the codec.
    """
    black_dn = black_by_light(setting.seen, setting.scenery)
    if black_dn is None:
        return None
    plain = base.plain()
    alike = channels_alike(plain) if "G" in plain.channels else plain
    hidden_dn2 = np.full_like(black_dn, ROUNDING_DN2)
    return dataclasses.replace(
        alike,
        read_dn2=hidden_dn2,
        fpn_dn2=hidden_dn2,
        black_dn=np.full_like(black_dn, black_dn.mean()),
        dark_e_per_s=0.0,
        shown_e_per_s=0.0,
    )
