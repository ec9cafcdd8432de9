"""A camera whose picture trembles, by what is even in it.

Edges that go to and fro change by far more than their light does. A camera that was calibrated to
all samples has the gain of that noise, several times its own, and little light.
"""

from __future__ import annotations

import numpy as np

from analysis.gap.calibrate.first_guess import Full
from analysis.gap.ready.full_well import lit
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting
from analysis.gap.ready.typical_noise import typical_gain

STEADY = 0.6
"""Part of a gain by all samples below which that of typical ones says that some tremble. Of 19
captures by somebody else whose picture does not it was 0.89 to 1.2."""


def trembling(setting: Setting) -> DirectReading | None:
    """Where the camera begins whose picture trembles; None where typical samples have about as much
    noise as all.

    Args:
        setting: the capture.
    """
    shots = lit(setting.key_frames)
    if not shots:
        return None
    nowhere = np.full(len(setting.seen.channels), np.inf)
    gain = typical_gain(setting, {stack.shot.label: nowhere for stack in shots})
    if gain is None:
        return None
    _, usual = by_moments(setting)
    if (gain > STEADY * usual.gain_dn_per_e).any():
        return None
    _, base = by_moments(setting, full=Full(levels_dn={}, gain_dn_per_e=gain))
    return DirectReading(hints={}, exact=False, base=base)
