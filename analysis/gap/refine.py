"""Calibrate a base camera to a capture: twins, the difference, the knobs, and again."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.arithmetic import IN_FRACTIONS, OF_WHOLE_SAMPLES, RULES
from analysis.gap.base import Base
from analysis.gap.calibration import calibration
from analysis.gap.fit import SEEDS, lit_by_label, twins, with_keys
from analysis.gap.handles import moved
from analysis.gap.nuisance import Directions, directions, moved_twins
from analysis.gap.observe import Observation
from analysis.gap.space import Space, figure_variances, space_of
from analysis.gap.twin import Scenery
from sensor.effect import Effect

Floats = NDArray[np.float64]

MOST_STEPS = 10
STEP_TWINS = 4

CLOSE = 0.1
"""Part of chi-squared that a last step takes off at most, of a model that fits."""

STUCK = 0.03
"""The same of one that does not, of which more steps may be worth their time."""

STUCK_OF_EXCESS = 0.1
"""The same of what chi-squared has beyond that: a misfit in few figures is little of the whole."""

LEAST_FALL = 0.005
"""Part of chi-squared that no step is worth, wherever it is."""

PATIENCE = 1
"""Steps in a row that may take off less than that, far from the end."""

FITS = 1.0
"""Chi-squared per coordinate up to which a model fits as well as chance allows."""

FAR = 2.0
"""Chi-squared per coordinate of a model that does not fit."""

A_LONG_WAY = 0.8
"""Part of chi-squared that is left where directions are read anew: they change on a long way."""

MOST_GAIN_STEP = 0.4


def refine(
    start: Base,
    seen: Observation,
    scenery: Scenery,
    effects: Sequence[Effect] = (),
    *,
    steps: int = MOST_STEPS,
    tuned: str = "",
) -> tuple[Base, tuple[Effect, ...]]:
    """Gauss-Newton on the knobs against simulated frames: the base whose twins look like these.

    Args:
        start: by moments.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
        steps: iterations at most.
        tuned: name of the effect whose parameters are fitted along.

    Returns:
        The base, and the effects.
    """

    def at(base: Base, effects: tuple[Effect, ...]) -> _Point:
        space, gap = _gap(base, seen, scenery, effects)
        return _Point(base=base, effects=effects, space=space, gap=gap, chi2=float(gap @ gap))

    def stepped(point: _Point) -> tuple[Base, tuple[Effect, ...]]:
        amounts = calibration(point.space, ways).amounts(point.gap)
        effects = (tune(e, ways, amounts) if e.name == tuned else e for e in point.effects)
        return turn(point.base, ways, amounts), tuple(effects)

    def promised(point: _Point) -> float:
        left = calibration(point.space, ways).left(point.gap)
        return point.chi2 - float(left @ left)

    best = read_at = at(start, tuple(effects))
    ways = _directions(best.base, scenery, best.effects)
    slow = 0
    for _ in range(steps - 1):
        next_one = at(*stepped(best))
        count, fall = len(next_one.gap), best.chi2 - next_one.chi2
        if fall <= 0:
            # uphill: these directions are not those of this place, if they promise anything
            if best is read_at or promised(best) < STUCK * best.chi2:
                return best.base, best.effects
            ways, read_at = _directions(best.base, scenery, best.effects), best
            continue
        slow = slow + 1 if fall < _least_fall(best.chi2, count) else 0
        best = next_one
        if slow > (PATIENCE if best.chi2 > FAR * count else 0):
            break
        if FITS * count < best.chi2 < A_LONG_WAY * read_at.chi2:
            ways, read_at = _directions(best.base, scenery, best.effects), best
    return stepped(best)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Point:
    """A camera, and its difference from a capture."""

    base: Base
    effects: tuple[Effect, ...]
    space: Space
    gap: Floats
    chi2: float


def _least_fall(chi2: float, count: int) -> float:
    """What a further step must take off chi-squared."""
    excess = chi2 - FITS * count
    if excess < 0:
        return CLOSE * chi2
    return max(LEAST_FALL * chi2, min(STUCK * chi2, STUCK_OF_EXCESS * excess))


def misfit(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect] = ()
) -> float:
    """Chi-squared of a base per coordinate: about 1 where it fits.

    Args:
        base: calibrated.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
    """
    return float(np.square(_gap(base, seen, scenery, effects)[1]).mean())


def counted(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect] = ()
) -> Base:
    """The base with the arithmetic of its demosaicer that fits best; the same where it fits.

    Processing behind a demosaicer that counts in whole numbers hides from `arithmetic_of` that it
    does.

    Args:
        base: calibrated.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
    """
    if scenery.body.pixels != "rgb8":
        return base

    best, least = base, misfit(base, seen, scenery, effects)
    if least < FAR:
        return base
    for rule in (IN_FRACTIONS, *RULES, OF_WHOLE_SAMPLES):
        other = dataclasses.replace(base, arithmetic=rule)
        if (now := misfit(other, seen, scenery, effects)) < least:
            best, least = other, now
    return best


def _gap(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect]
) -> tuple[Space, Floats]:
    """The difference of a capture from a few twins, and the space it is in."""
    bodies = twins(scenery, base, STEP_TWINS, effects)
    both = with_keys(seen, bodies.keys)
    variances = figure_variances(bodies, lit_by_label(scenery), scenery.light.known)
    space = space_of(bodies, variances, base, scenery, seen.groups, seen=both)
    return space, space.of(both)


def _directions(base: Base, scenery: Scenery, effects: Sequence[Effect]) -> Directions:
    return directions(base, scenery, moved_twins(base, scenery, SEEDS, effects))


def turn(base: Base, ways: Directions, amounts: Floats) -> Base:
    """A base with its knobs turned."""
    for knob, amount in zip(ways.knobs, amounts, strict=False):
        by = float(amount)
        if knob.name == "gain" or knob.name.startswith("level"):
            by = float(np.clip(by, -MOST_GAIN_STEP, MOST_GAIN_STEP))
        base = base.moved(knob.name, knob.channel, by)
    return base


def tune(effect: Effect, ways: Directions, amounts: Floats) -> Effect:
    """An effect with its parameters moved, each inside its range."""
    moves = dict(zip(ways.tuned, map(float, amounts[len(ways.knobs) :]), strict=False))
    return moved(effect, {h: by for h, by in moves.items() if h.effect == effect.name})
