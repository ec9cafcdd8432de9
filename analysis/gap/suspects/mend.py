"""What is done to pictures hides how a demosaicer counts, and is fitted by how it seems to count.

Whoever mends one of the two sees the other one better, so that they take turns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from analysis.gap.calibrate.counting import by_rule, counted
from analysis.gap.calibrate.refine import Refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.arithmetic import RULES
from analysis.gap.look.observation import Observation
from analysis.gap.measure.case import MISFIT, Candidate
from analysis.gap.suspects.valley import another_valley
from sensor.effect import Effect

Tried = tuple[Candidate, Refined]
"""A suspect and the camera that was calibrated with it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Search:
    """How the calibration with a suspect goes on.

    Attributes:
        seen: the frames that fit.
        scenery: their light and shots.
        calibrated: from another camera and effect on.
        off: whether a model leaves what should be mended.
    """

    seen: Observation
    scenery: Scenery
    calibrated: Callable[[Base, Effect], Tried]
    off: Callable[[Refined], bool]


TURNS = 2
"""Of either, where each helps the other: a filter in space was fitted with half of its strength as
one of fractions, a likelier strength was found beside that, and only from there the calibration
led to whole numbers and to all of it."""


def likelier(one: Tried, other: Tried) -> Tried:
    """The widest model leaves least, and is not the likeliest."""
    return other if other[1].deviance < one[1].deviance else one


def mended(found: Tried, search: Search) -> Tried:
    """The suspect with the way of counting and the strength that are likeliest.

    Args:
        found: where the calibration ended.
        search: how it goes on.
    """
    for _ in range(TURNS):
        if not search.off(found[1]):
            break
        before = found
        found = _revalued(_recounted(found, search), search)
        if found is before:
            break
    return found


def _revalued(found: Tried, search: Search) -> Tried:
    """With a strength that no small step leads to."""
    valley = None
    if search.off(found[1]):
        valley = another_valley(found[1], search.seen, search.scenery)
    if valley is None:
        return found
    return likelier(found, search.calibrated(valley.base, valley.effects[-1]))


def _recounted(found: Tried, search: Search) -> Tried:
    """As the demosaicer seems to count with the suspect as strong as it is now, and in whole
    numbers, which what is done to them hides.
    """
    base = counted(found[1], search.seen, search.scenery, enough=MISFIT).base
    if base is not found[1].base:
        found = likelier(found, search.calibrated(base, found[1].effects[-1]))
    for rule in RULES:
        now = found[1]
        if not search.off(now):
            break
        if rule in search.scenery.rules and rule != now.base.arithmetic:
            other = search.calibrated(by_rule(now.base, rule), now.effects[-1])
            found = likelier(found, other)
            if found[1] is now and now.base.arithmetic not in RULES:
                break  # one whole number is much like another
    return found
