"""When an effect may stand beside one that was added before.

What is left of a gap is easily blamed: a model that is right to a tenth leaves a hundredth of
chi-squared to whoever comes next. So a later effect is more than such a remainder, or it closes
most of the little that there is.
"""

from __future__ import annotations

from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured
from analysis.gap.report import EQUIVALENT
from analysis.gap.search.choice import (
    BEYOND_CALIBRATION,
    BUMPS,
    DRAWN,
    LEAST_SHRINK,
    SIGNIFICANCE,
    TELLS_LITTLE,
)
from analysis.gap.search.closing import closed, untouched
from analysis.gap.search.step import Step

LEAST_OF_A_LATER = 25.0
"""Score of an effect that is added to another one."""

PART_OF_THE_FIRST = 0.02
"""The same, as a part of the first one's score."""

LEAST_WHERE_LITTLE = 50.0
"""The same where little is left. After the one effect of ten captures no other suspect had more
than 9; after the first of two strong ones, in four more, the other one had 78 to 279."""

LITTLE_IS_LEFT = 0.25
"""G that one effect may close which is much less than the first."""

MOST_OF_A_SECOND = 0.5
"""Part of the gap that a second cause does not close by itself if calibration takes it up."""

LEADS = 0.25
"""Part of a gap that a first effect closes. Of two that close four fifths together the larger one
closes two fifths, less where the other one hides it. Beside one that closes less than this part
nothing is looked for."""

CLOSES_LITTLE = 0.9
"""Part of the gap that a later effect must not leave."""


def stands_beside(later: Candidate, first: Candidate) -> bool:
    """Whether an effect is more than what an error of another one's model leaves.

    Args:
        later, first: the effects.
    """
    return later.score > max(LEAST_OF_A_LATER, PART_OF_THE_FIRST * first.score)


def deserves(
    later: Candidate, first: Candidate, base: Measured, now: Measured, apart: float = 0.0
) -> bool:
    """Whether an effect is to be tried beside another one.

    One that is much less than the first is tried where little is left, or where the first one left
    a family alone that is wrong beyond doubt, or where it shows in what the first did not move: all
    that is no remainder of it. One more bump is not beside a drawn pattern with which nothing is
    left. What calibration takes up for nine tenths is not, unless it is more
    than a remainder and beyond doubt.

    Args:
        later, first: the effects.
        base, now: the capture against the models without any effect, and with the first.
        apart: score of the later one in what the first cannot have left; see `remainder`.
    """
    if {later.name, first.name} <= BUMPS and first.name in DRAWN and _explained(now):
        return False
    little = not _explained(now) and now.held.total < LITTLE_IS_LEFT
    enough = later.score > LEAST_WHERE_LITTLE
    tried = enough and (little or untouched(base, now, worth=0.0))
    large = stands_beside(later, first) or apart > LEAST_WHERE_LITTLE
    if later.absorbed >= EQUIVALENT:
        beyond = later.score > BEYOND_CALIBRATION and first.name not in DRAWN
        return large and beyond
    return bool(tried or large)


def _explained(now: Measured) -> bool:
    return now.whole.p_value >= SIGNIFICANCE


def leads(first: Step, base: Measured) -> bool:
    """Whether a first effect closes so much of a gap that another one may close the rest.

    Args:
        first: by which it was added.
        base: the capture against the model without any effect.
    """
    gap = base.held.total
    tells = gap > LITTLE_IS_LEFT and not first.ends
    return not tells or closed(gap, first.left.held.total, base.floor) >= LEADS


def earned(step: Step, base: Measured, now: Measured, first: Candidate) -> bool:
    """Whether a later effect keeps its place: a large one that calibration leaves if it closes
    something, another if it closes most of what the first one leaves, or all that the first one
    left alone.

    Args:
        step: by which it was added.
        base, now: the capture against the models without any effect, and without this one.
        first: the first effect.
    """
    gap, left = now.held.total, step.left.held.total
    if gap > TELLS_LITTLE and left > CLOSES_LITTLE * gap:
        return False
    most = closed(gap, left) >= LEAST_SHRINK
    left_alone = untouched(base, now, worth=0.0)
    other_cause = bool(left_alone) and not untouched(base, step.left, worth=0.0)
    best = step.choice.best
    large = stands_beside(best, first) and best.absorbed < EQUIVALENT
    return step.ends or most or other_cause or large


def no_worse(alone: Measured, both: Measured) -> bool:
    """Whether a later effect by itself leaves hardly more than it does with those before it.

    Args:
        alone, both: the capture against the model with the later one, and with all.
    """
    more = alone.held.total - both.held.total
    return more * float(alone.rod.spread.expected.sum()) < LEAST_OF_A_LATER


def instead_of_it(later: Candidate, base: Measured, alone: Measured) -> bool:
    """Whether a later effect that calibration takes up closes most of the gap by itself: then it is
    a rival of the first, and both together may be a third one.

    Args:
        later: the effect.
        base, alone: the capture against the models without any effect, and with this one.
    """
    most = closed(base.held.total, alone.held.total) > MOST_OF_A_SECOND
    return later.absorbed >= EQUIVALENT and most
