"""What is done to pictures hides how a demosaicer counts, and is fitted by how it seems to count.

Whoever mends one of the two sees the other one better, so that they take turns.
"""

from __future__ import annotations

from collections.abc import Callable

from analysis.gap.calibrate.counting import by_rule, counted
from analysis.gap.calibrate.refine import Refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.arithmetic import RULES
from analysis.gap.look.observation import Observation
from analysis.gap.measure.case import Candidate
from analysis.gap.suspects.valley import another_valley
from sensor.effect import Effect

Tried = tuple[Candidate, Refined]
"""A suspect and the camera that was calibrated with it."""

Calibrated = Callable[[Base, Effect], Tried]
"""Calibrates from a camera and an effect on."""

MISFIT = 1.2
"""Part of the expected chi-squared beyond which the camera is calibrated with the suspect in it."""

TURNS = 2
"""Of either, where each helps the other: a filter in space was fitted with half of its strength as
one of fractions, a likelier strength was found beside that, and only from there the calibration
led to whole numbers and to all of it."""


def likelier(one: Tried, other: Tried) -> Tried:
    """The widest model leaves least, and is not the likeliest."""
    return other if other[1].deviance < one[1].deviance else one


def mended(
    found: Tried,
    seen: Observation,
    scenery: Scenery,
    calibrated: Calibrated,
    off: Callable[[Refined], bool],
) -> Tried:
    """The suspect with the way of counting and the strength that are likeliest.

    Args:
        found: where the calibration ended.
        seen: the frames that fit.
        scenery: their light and shots.
        calibrated: goes on from another camera and effect.
        off: whether a model leaves what should be mended.
    """
    for _ in range(TURNS):
        before = found
        found = _recounted(found, seen, scenery, calibrated, off)
        valley = another_valley(found[1], seen, scenery) if off(found[1]) else None
        if valley is not None:
            found = likelier(found, calibrated(valley.base, valley.effects[-1]))
        if found is before or not off(found[1]):
            break
    return found


def _recounted(
    found: Tried,
    seen: Observation,
    scenery: Scenery,
    calibrated: Calibrated,
    off: Callable[[Refined], bool],
) -> Tried:
    """As the demosaicer seems to count with the suspect as strong as it is now, and in whole
    numbers, which what is done to them hides.
    """
    if not off(found[1]):
        return found
    base = counted(found[1], seen, scenery, enough=MISFIT)
    if base is not found[1].base:
        found = likelier(found, calibrated(base, found[1].effects[-1]))
    for rule in RULES:
        now = found[1]
        if not off(now):
            break
        if rule in scenery.rules and rule != now.base.arithmetic:
            found = likelier(found, calibrated(by_rule(now.base, rule), now.effects[-1]))
            if found[1] is now and now.base.arithmetic not in RULES:
                break  # one whole number is much like another
    return found
