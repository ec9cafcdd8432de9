"""Where any search for a camera can begin: the base by moments of its frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.darks import Darks, darks_of
from analysis.gap.calibrate.first_guess import Full, first_guess
from analysis.gap.camera.base import Base
from analysis.gap.ready.setting import Setting, halves

Floats = NDArray[np.float64]


def by_moments(setting: Setting, *, full: Full | None = None) -> tuple[Darks, Base]:
    """What the darks show, and the base, of the frames that fit.

    Args:
        setting: the capture.
        full: what is known of full photosites, where there are any.
    """
    fit_half, _ = halves(setting.seen)
    dark = darks_of(fit_half, setting.scenery, setting.black_dn)
    base = first_guess(fit_half, setting.scenery, None, dark, full=full)
    return dark, setting.counting.of(base)


def gains_of(setting: Setting) -> dict[str, float]:
    """Gains by moments in DN/e-, by channel.

    Args:
        setting: the capture.
    """
    _, base = by_moments(setting)
    return by_channel(base)


def by_channel(base: Base) -> dict[str, float]:
    """Gains of a camera in DN/e-, by channel."""
    return dict(zip(base.channels, map(float, base.gain_dn_per_e), strict=True))
