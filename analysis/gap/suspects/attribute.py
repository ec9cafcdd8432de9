"""Which effect: every suspect at the strength that fits, scored on frames that did not fit it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

import numpy as np

from analysis.gap.measure.case import Candidate, Case, candidate
from analysis.gap.measure.signature import (
    Evidence,
    Signature,
    hold,
    response_of,
    scaled,
    signature,
)
from analysis.gap.ready.hints import Told
from analysis.gap.suspects.anew import MISFIT, anew
from analysis.gap.suspects.likelihood import judged
from analysis.gap.suspects.pursue import LONG, pursue

ROUNDS = 2
"""How often a suspect is simulated again at the strength that it seems to have."""

RIGHT = (0.75, 1.33)
"""An amount in this range needs no further round."""

WORTH_A_LOOK = 6.0
"""A suspect that takes less off chi-squared is not followed."""

ADAPTED = 7
FINALISTS = 3

LIKELIEST = 2
"""Finalists of which frames tell nothing, where none of those of which they do fits."""

NEAR = 0.2
"""A suspect with less than this part of the best score is no finalist."""

RIVAL = 0.5
"""Part of the best score from which another one is its rival."""

FAR_WORSE = 3.0
"""Times the misfit without a suspect from which the camera is not calibrated anew with it."""

NOTHING_TOLD: Mapping[str, Told] = MappingProxyType({})


def attribute(
    case: Case,
    shown: Iterable[Signature],
    watch: Callable[[str], None] = lambda name: None,
    *,
    told: Mapping[str, Told] = NOTHING_TOLD,
) -> list[Candidate]:
    """Every suspect that these frames may show, best first.

    Args:
        case: the capture.
        shown: how the suspects show, here or at a model near this one; see `first_look`.
        told: suspects of which the frames tell parameters: they are followed in any case.
        watch: told whose turn it is.
    """
    keys = case.fitting.turned.space.keys
    first = _best_of_each(_held(case, one.on(keys)) for one in shown)
    adapted = []
    evident = [e for e in first if e.name in told]
    possible = [e for e in first if e not in evident and not too_much(e)]
    for found in possible[:ADAPTED]:
        if found.score > WORTH_A_LOOK:
            watch(found.name)
            adapted.append(_adapt(case, found))
    adapted.sort(key=lambda e: -e.score)
    likely = [e for e in adapted if e.score > NEAR * adapted[0].score]
    candidates: list[Candidate] = []
    for found in evident:
        watch(found.name)
        candidates.append(anew(case, _as_it_is(case, found), found.effect, told[found.name]))
    # what frames seem to tell may be another effect's doing, so the likeliest are followed as well
    least = LIKELIEST if all(c.misfit > MISFIT for c in candidates) else 0
    finalists = likely[: max(FINALISTS - len(evident), least)]
    for found in finalists:
        watch(found.name)
        candidates.append(pursue(case, found))
    expected = float(case.fitting.spread.expected.sum())
    without = float(np.square(case.fit_left).sum()) / expected
    most = max((c.score for c in candidates[len(evident) :]), default=0.0)
    for place, found in enumerate(finalists, start=len(evident)):
        # the strongest effect is the first, and calibration has known it since
        if case.known.effects or any(c.misfit <= MISFIT for c in candidates):
            break
        far = candidates[place].misfit > FAR_WORSE * without
        # a pursuit may lead nowhere, and it may lead past the one that looked best before
        rival = found.score > RIVAL * likely[0].score or candidates[place].score > RIVAL * most
        if rival and not far:
            watch(found.name)
            candidates[place] = anew(case, candidates[place], found.effect)
    # calibrated with its own suspect, a camera's errors may be others: scores say little of that
    unexplained = expected * (without - 1.0)
    candidates = judged(case, candidates, unexplained)
    done = {c.name for c in candidates}
    candidates += [_as_it_is(case, e) for e in [*adapted, *first] if e.name not in done]
    unique = {c.name: c for c in reversed(candidates)}
    return sorted(unique.values(), key=lambda c: -c.score)


def at_first_sight(case: Case, shown: Iterable[Signature]) -> Candidate | None:
    """The best suspect as it is, by how all of them show elsewhere: nothing is simulated.

    Args:
        case: the capture.
        shown: how the suspects show at a model near this one.
    """
    keys = case.fitting.turned.space.keys
    seen = [_as_it_is(case, one) for one in _best_of_each(_held(case, s.on(keys)) for s in shown)]
    return max(seen, key=lambda one: one.score, default=None)


def _best_of_each(evidence: Iterable[Evidence]) -> list[Evidence]:
    """The best of each suspect, best first."""
    best: dict[str, Evidence] = {}
    for one in evidence:
        if one.name not in best or one.score > best[one.name].score:
            best[one.name] = one
    return sorted(best.values(), key=lambda e: -e.score)


def _held(case: Case, shown: Signature) -> Evidence:
    return hold(shown, case.fitting.turned, case.fit_left)


LEAST_OF_A_STEP = 0.2
"""Amount of an effect that comes in steps below which even one step of it is out of the question:
another camera than the calibrated one makes it seem smaller or larger, but not by that much."""


def too_much(found: Evidence) -> bool:
    """Whether an effect that comes in steps would do many times as much as there is.

    Args:
        found: the suspect as it is held against a capture.
    """
    a_scale = any(p.whole and p.maximum - p.minimum >= LONG for p in found.effect.parameters())
    comes_in_steps = scaled(found.effect, 0.5) == found.effect and not a_scale
    return comes_in_steps and found.amount < LEAST_OF_A_STEP


def _adapt(case: Case, found: Evidence) -> Evidence:
    """Simulate at the strength it seems to have, until it has it."""
    here = signature(found.effect, case.known) if case.known.effects else None
    best = found = found if here is None else _held(case, here)
    factor, response = 1.0, 1.5
    tried: list[tuple[float, float]] = [(1.0, found.amount)]
    for _ in range(ROUNDS):
        amount = tried[-1][1]
        if RIGHT[0] <= amount <= RIGHT[1] or amount == 0.0:
            break
        if amount < 0:
            factor = -factor * min(abs(amount), 4.0)
        else:
            factor *= float(np.clip(amount ** (1.0 / response), 0.1, 8.0))
        moved = signature(scaled(found.effect, factor), case.known)
        if moved is None or moved.effect == best.effect:
            break
        shown = _held(case, moved)
        tried.append((factor, shown.amount))
        response = response_of(tried, response)
        wrong = not RIGHT[0] <= best.amount <= RIGHT[1]
        if shown.score > best.score or (wrong and shown.score > RIVAL * best.score):
            best = shown
    return best


def _as_it_is(case: Case, found: Evidence) -> Candidate:
    """A suspect that was not followed, at the amount that least squares gives it; one that comes in
    steps and would do too much is as it would be.
    """
    amount = 1.0 if too_much(found) else found.amount
    return candidate(case, found.signature, case.known.base, found.absorbed, amount)
