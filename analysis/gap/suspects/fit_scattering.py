"""Fit an effect that makes bodies differ, in the space of a model that has it.

Spots that lie elsewhere in each body leave the mean over bodies almost as it was. What there is of
them is in how far blocks scatter, how far that reaches and to which side, and in units of the
errors of a camera without spots all of them are beyond any scale. With them in the model the same
figures tell their number, size and depth in two or three steps.
"""

from __future__ import annotations

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.calibrate.turning import tune, turn
from analysis.gap.camera.base import Base
from analysis.gap.measure.case import Case
from analysis.gap.measure.distance import distance
from analysis.gap.measure.twins_spread import spread_of
from sensor.effect import Effect

ROUNDS = 4
"""Models that are made with an effect, at most, one from each step of the fit."""

FITS = 0.05
"""Chance of what is left from which no further step is taken."""


def settled(case: Case, base: Base, effect: Effect, *, tuned: bool = True) -> tuple[Fit, float]:
    """The model with the effect, after some steps with everything known around both; and how far
    it is from the frames, as a part of what is expected.

    Args:
        case: the capture; its frames that fit are used.
        base: the camera.
        effect: as it was found by the errors of a model without it.
        tuned: whether its parameters are fitted: not where frames tell them to the last digit.
    """
    known = case.known
    best, nearest = None, float("inf")
    for _ in range(ROUNDS):
        model = around(base, known.scenery, (*known.effects, effect))
        seen = model.textured(case.fit_seen)
        turned = model.calibration_for(seen)
        gap = turned.space.of(seen)
        now = distance(turned.left(gap), spread_of(model, seen.groups))
        if best is not None and abs(now.total) > nearest:
            break
        best, nearest = model, abs(now.total)
        if now.p_value >= FITS:
            break
        amounts = turned.amounts(gap)
        base = turn(base, model.ways, amounts)
        effect = tune(effect, model.ways, amounts) if tuned else effect
    assert best is not None
    return best, nearest
