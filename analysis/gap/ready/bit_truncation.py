"""Where a camera begins that has lost bits: by what is left of its noise in lit shots.

Steps that are wide beside the noise hide all of it in the darks, which have one code, and make far
more of it in lit shots than there is. But levels of a picture lie anywhere between two steps, and
what is left of noise on average over them tells how much there was, so that a line through lit
shots tells gain, read noise and black level.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import before_rounding_dn2
from analysis.gap.calibrate.darks import LEAST_READ_DN2, black_by_light
from analysis.gap.camera.base import Base
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.setting import Setting, halves

Floats = NDArray[np.float64]

HIDDEN = 0.5
"""Part of a step below which noise of darks is hidden: as of any rounding."""


def behind_steps(setting: Setting, told: DirectReading, base: Base) -> Base | None:
    """The base with the noise and the black level that lit shots have in front of the steps; None
    where darks show theirs, or lit shots do not tell them.

    Args:
        setting: the capture.
        told: how many bits are lost.
        base: calibrated without that.
    """
    seen, _ = halves(setting.seen)
    bits = told.hints["bits"]
    assert isinstance(bits, float), "bits are lost of all colours"
    lit = [k for k, label in enumerate(seen.shots) if label in seen.lit]
    black_dn = black_by_light(seen, setting.scenery)
    if black_dn is None:
        return None
    plain, gains = base.plain(), base.white_balance
    of_code = base.gain_of_balance
    step_dn = 2.0**bits * of_code
    noise_dn2 = np.square(step_dn) * before_rounding_dn2(seen.noise[lit] / np.square(step_dn))
    signal_dn = seen.means.mean(axis=(0, 3))[lit] - black_dn
    gain, read_dn2 = _lines(signal_dn, noise_dn2)
    if (gain <= 0).any() or (read_dn2 > np.square(HIDDEN * step_dn)).any():
        return None
    made = dataclasses.replace(
        plain,
        gain_dn_per_e=gain,
        read_dn2=np.maximum(read_dn2, LEAST_READ_DN2),
        # codes in front of the steps are those of a step and the ones above it
        black_dn=black_dn + (step_dn - of_code) / 2,
        dark_e_per_s=0.0,
        shown_e_per_s=0.0,
        level={n: level * plain.gain_dn_per_e / gain for n, level in plain.level.items()},
    )
    return made if gains is None else made.multiplied(gains, base.origin_dn)


def _lines(signal_dn: Floats, noise_dn2: Floats) -> tuple[Floats, Floats]:
    """Slope and intercept of noise over signal, (shots, channels), per channel."""
    pairs = zip(signal_dn.T, noise_dn2.T, strict=True)
    slope, intercept = np.array([np.polyfit(x, y, 1) for x, y in pairs]).T
    return slope, intercept
