"""A suspect at the strength that it seems to have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analysis.gap.measure.case import Case
from analysis.gap.measure.signature import Evidence, hold, scaled, signature
from sensor.effect import Effect

ROUNDS = 3
"""How often a suspect is simulated again at the strength that it seems to have."""

RIGHT = (0.75, 1.33)
"""Strengths this near to each other need no further round."""

USUAL_RESPONSE = 1.5
"""Power of the strength with which a signature grows, until two strengths have been tried: noise
shows as its variance, what bends and blurs as itself."""

RESPONSES = (0.5, 4.0)
"""Powers that are believed; between a strength that shows less and one that shows more any higher
one is."""

ABOUT = 4.0
"""Amounts up to which, either way, a strength is about right."""

ASTRAY = 0.2
"""Part of the clearest score that another strength must have where the clearest is about right:
what grows by no power of its strength, as where photosites are full, is not followed further."""

NEXT_TO_NOTHING = 1e-3
"""Part of what the capture has that no strength shows less of."""

HALVINGS = 3
"""Strengths that are tried between one that shows nothing and one that shows too much."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Adapted:
    """A suspect at the strengths at which it was simulated.

    Attributes:
        effect: as strong as the capture has it.
        nearest: simulated with about that strength.
        clearest: with the one whose signature takes most off chi-squared. The difference of two
            twins has the same noise whatever the strength, so that of a weak effect a strong one's
            is the better picture.
    """

    effect: Effect
    nearest: Evidence
    clearest: Evidence


def adapted(case: Case, found: Evidence) -> Adapted:
    """Simulate a suspect at the strength it seems to have, until it has it.

    Args:
        case: the capture.
        found: the suspect, at this model or at one before it.
    """
    turned = case.fitting.turned
    here = signature(found.effect, case.known) if case.known.effects else None
    tried = {1.0: found if here is None else hold(here, turned, case.fit_left)}

    def simulated(factor: float) -> bool:
        """Try a strength; False where the suspect cannot be had with it, or was before."""
        moved = signature(scaled(found.effect, factor), case.known)
        if moved is None or moved.effect in {one.effect for one in tried.values()}:
            return False
        tried[factor] = hold(moved, turned, case.fit_left)
        return True

    for _ in range(ROUNDS):
        aim = _aim(case, tried)
        known = any(RIGHT[0] <= aim / factor <= RIGHT[1] for factor in tried)
        if aim == 0 or known or not simulated(aim):
            break
    for _ in range(HALVINGS):
        between = _between(case, tried)
        if between is None or not simulated(between):
            break
    clearest, aim = _clearest(tried), _aim(case, tried)
    near = min(tried, key=lambda factor: abs(np.log(factor / aim)) if factor * aim > 0 else np.inf)
    if _about_right(clearest) and tried[near].score < ASTRAY * clearest.score:
        return Adapted(effect=clearest.effect, nearest=clearest, clearest=clearest)
    return Adapted(effect=scaled(found.effect, aim), nearest=tried[near], clearest=clearest)


def _about_right(found: Evidence) -> bool:
    """Whether an effect is about as strong as the capture has it."""
    return 1 / ABOUT <= found.amount <= ABOUT


def _clearest(tried: Mapping[float, Evidence]) -> Evidence:
    return max(tried.values(), key=lambda one: one.score)


def _factor(tried: Mapping[float, Evidence], one: Evidence) -> float:
    return next(factor for factor, other in tried.items() if other is one)


def _shown(case: Case, tried: Mapping[float, Evidence]) -> list[tuple[float, float]]:
    """How much of the clearest signature each strength shows, by factor, as a part of what the
    capture has of it; nearest first to as much. None shows less than next to nothing.

    Args:
        case: the capture, which has some of it.
        tried: the effect by factor of its strength.
    """
    clearest = _clearest(tried)
    own = _factor(tried, clearest)
    space = case.fitting.turned.space
    template = clearest.left[: len(space.families)] / clearest.norm
    # below a threshold there is nothing, whatever the noise says
    known = [
        (
            factor,
            max(
                float(space.vector(*one.signature.plain) @ template) / clearest.amount,
                NEXT_TO_NOTHING,
            ),
        )
        for factor, one in tried.items()
        if factor * own > 0
    ]
    return sorted(known, key=lambda one: abs(np.log(one[1])))


def _between(case: Case, tried: Mapping[float, Evidence]) -> float | None:
    """A strength between the strongest that shows nothing and the weakest that shows more than the
    capture has; None where one shows about as much.

    What sets in above a full well or a threshold grows by no power of its strength: of a full well
    of 16.6 ke- one of 14 shows so much that 31 seemed right, which no photosite fills.

    Args:
        case: the capture.
        tried: the effect by factor of its strength.
    """
    if _clearest(tried).amount <= 0:
        return None
    shown = _shown(case, tried)
    nothing = [abs(factor) for factor, part in shown if part <= NEXT_TO_NOTHING]
    too_much = [abs(factor) for factor, part in shown if part > RIGHT[1]]
    some = len(shown) - len(nothing) - len(too_much)
    if some or not nothing or not too_much or max(nothing) >= min(too_much):
        return None
    return float(np.copysign(np.sqrt(max(nothing) * min(too_much)), shown[0][0]))


def _aim(case: Case, tried: Mapping[float, Evidence]) -> float:
    """The strength, as a factor, with which an effect shows as much of its clearest signature as
    the capture has: what each strength shows of it is known far better than the capture is.

    Args:
        case: the capture.
        tried: the effect by factor of its strength.
    """
    clearest = _clearest(tried)
    if clearest.amount <= 0:
        return -_factor(tried, clearest) * min(-clearest.amount, 4.0)
    (factor, part), *others = _shown(case, tried)
    response = USUAL_RESPONSE
    if others:
        beyond = [one for one in others if (one[1] > 1.0) is not (part > 1.0)]
        other, other_part = (beyond or others)[0]
        least, most = RESPONSES[0], np.inf if beyond else RESPONSES[1]
        response = float(np.clip(np.log(part / other_part) / np.log(factor / other), least, most))
    return factor * float(np.clip(part ** (-1.0 / response), 0.1, 8.0))
