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
from analysis.gap.suspects.first_look import WORTH_A_LOOK
from analysis.gap.suspects.likelihood import judged
from analysis.gap.suspects.pursue import pursue

ROUNDS = 2
"""How often a suspect is simulated again at the strength that it seems to have."""

RIGHT = (0.75, 1.33)
"""An amount in this range needs no further round."""

ADAPTED = 7
FINALISTS = 3
NEAR = 0.2
"""A suspect with less than this part of the best score is no finalist."""

RIVAL = 0.5
"""Part of the best score from which another one is its rival."""

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
    for found in first[:ADAPTED]:
        if found.score > WORTH_A_LOOK and found not in evident:
            watch(found.name)
            adapted.append(_adapt(case, found))
    adapted.sort(key=lambda e: -e.score)
    likely = [e for e in adapted if e.score > NEAR * adapted[0].score]
    finalists = [*evident, *likely][:FINALISTS]
    candidates: list[Candidate] = []
    for found in finalists:
        watch(found.name)
        if found in evident:
            as_it_is, start = _as_it_is(case, found), told[found.name]
            candidates.append(anew(case, as_it_is, found.effect, start))
            continue
        pursued = pursue(case, found)
        # the strongest effect is the first, and calibration has known it since
        rival = found.score > RIVAL * likely[0].score and not case.known.effects
        if rival and all(c.misfit > MISFIT for c in (pursued, *candidates)):
            pursued = anew(case, pursued, found.effect)
        candidates.append(pursued)
    # calibrated with its own suspect, a camera's errors may be others: scores say little of that
    unexplained = float(np.square(case.fit_left).sum() - case.fitting.spread.expected.sum())
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
    """A suspect that was not followed, at the amount that least squares gives it."""
    return candidate(case, found.signature, case.known.base, found.absorbed, found.amount)
