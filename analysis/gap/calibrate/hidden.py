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
from analysis.gap.calibrate.refine import WORTH_A_STEP, Refined, further, refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from sensor.effect import Effect

OF_OFFSETS = 0.2
"""Part of the variance of the fixed offsets that is dark current's in the longest dark, where a fit
begins that finds none."""


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
    if not dark.quiet or not _tell_a_spread(scenery):
        return found
    spread, uneven = found.base.dark_spread2 > 0, found.base.dark_uneven > 0
    if spread and not uneven:
        return found
    even = dataclasses.replace(found.base, dark_uneven=0.0)
    begun = refined(even if spread else part_of_the_offsets(even, scenery), seen, scenery, effects)
    # where nothing was taken for skewness there is a spread if a little of one promises it
    if not uneven and begun.deviance > found.deviance + WORTH_A_STEP:
        return found
    again = further(begun, seen, scenery)
    return again if again.deviance < found.deviance - WORTH_A_STEP else found


def lost_its_spread(base: Base, scenery: Scenery) -> bool:
    """Whether a camera has no spread of dark current where darks could tell one: a fit that came to
    none has nothing to step back by. Beside frames that wander one came to none.

    Args:
        base: the camera.
        scenery: light and shots.
    """
    return base.dark_spread2 == 0 and _tell_a_spread(scenery)


def _tell_a_spread(scenery: Scenery) -> bool:
    return len({shot.exposure_s for shot in scenery.shots if shot.dark}) > 1


def part_of_the_offsets(base: Base, scenery: Scenery) -> Base:
    """The camera with some of its fixed offsets as dark current's, as much in the mean of its
    darks.

    Args:
        base: without a spread of dark current.
        scenery: light and shots.
    """
    times2 = np.square([shot.exposure_s for shot in scenery.shots if shot.dark])
    offsets_e2 = float(np.mean(base.fpn_dn2 / base.gain_dn_per_e**2))
    return dataclasses.replace(
        base,
        dark_spread2=OF_OFFSETS * offsets_e2 / float(times2.max()),
        fpn_dn2=base.fpn_dn2 * (1.0 - OF_OFFSETS * float(times2.mean() / times2.max())),
    )
