"""Dark current that differs between photosites, in darks that rounding hides it in.

The pattern of darks grows with their exposure by as much as dark current differs. Less than half a
code of noise carries no pattern across the middle of a step: as the mean of the darks comes near to
a whole code, the pattern that is left shrinks while the one in front of the converter grows, and
moments say that there is little spread or none. A fit that begins so takes it for skewness, which
ends where no step leads back.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from analysis.gap.calibrate.darks import Darks
from analysis.gap.calibrate.refine import WORTH_A_STEP, Refined, refine
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from sensor.effect import Effect

OF_OFFSETS = 0.5
"""Part of the variance of the fixed offsets that dark current adds in the longest dark, where the
fit begins."""


def with_even_spread(
    found: Refined,
    dark: Darks,
    seen: Observation,
    scenery: Scenery,
    effects: Sequence[Effect] = (),
) -> Refined:
    """A calibrated camera, or one with an even spread from which a fit leads further.

    Args:
        found: calibrated.
        dark: what the darks show.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
    """
    exposures_s = {shot.exposure_s for shot in scenery.shots if shot.dark}
    if not dark.quiet or len(exposures_s) < 2:
        return found
    base = found.base
    offsets_e2 = float(np.mean(base.fpn_dn2 / base.gain_dn_per_e**2))
    spread2 = base.dark_spread2 or OF_OFFSETS * offsets_e2 / max(exposures_s) ** 2
    even = dataclasses.replace(base, dark_spread2=spread2, dark_uneven=0.0)
    again = refine(even, seen, scenery, effects)
    return again if again.deviance < found.deviance - WORTH_A_STEP else found
