"""Which effect: every suspect at the strength that fits, scored on frames that did not fit it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable

import numpy as np

from analysis.gap.case import Candidate, Case, candidate
from analysis.gap.fit import SEEDS
from analysis.gap.hints import Hints
from analysis.gap.observe import Observation
from analysis.gap.pursue import FINAL_SEEDS, pursue
from analysis.gap.suspects import Evidence, hold, response_of, scaled, signature, starts
from analysis.gap.twin import twin
from sensor.effect import Effect

ROUNDS = 2
"""How often a suspect is simulated again at the strength that it seems to have."""

RIGHT = (0.75, 1.33)
"""An amount in this range needs no further round."""

ADAPTED = 7
FINALISTS = 3
NEAR = 0.2
"""A suspect with less than this part of the best score is no finalist."""

WORTH_A_LOOK = 6.0
"""A suspect that takes less off chi-squared is not followed."""


def attribute(
    case: Case,
    kinds: Iterable[type[Effect]],
    hints: Hints,
    watch: Callable[[str], None] = lambda name: None,
) -> list[Candidate]:
    """Every suspect that these frames may show, best first."""
    references = {seed: _reference(case, seed) for seed in SEEDS}
    first: list[Evidence] = []
    for kind in kinds:
        watch(kind.name)
        best = _best_start(case, kind, hints, references)
        if best is not None:
            first.append(best)
    first.sort(key=lambda e: -e.score)
    adapted = []
    for found in first[:ADAPTED]:
        if found.score > WORTH_A_LOOK:
            watch(found.name)
            adapted.append(_adapt(case, found, references))
    adapted.sort(key=lambda e: -e.score)
    finalists = [e for e in adapted if e.score > NEAR * adapted[0].score][:FINALISTS]
    many = references
    if finalists:
        many = {
            seed: references[seed] if seed in references else _reference(case, seed)
            for seed in FINAL_SEEDS
        }
    candidates = []
    for found in finalists:
        watch(found.name)
        candidates.append(pursue(case, found, many))
    done = {c.name for c in candidates}
    candidates += [_as_it_is(case, e) for e in [*adapted, *first] if e.name not in done]
    unique = {c.name: c for c in reversed(candidates)}
    return sorted(unique.values(), key=lambda c: -c.score)


def _reference(case: Case, seed: int) -> Observation:
    known = case.known
    return known.textured(twin(known.scenery, known.base, effects=known.effects, seed=seed))


def _best_start(
    case: Case, kind: type[Effect], hints: Hints, references: dict[int, Observation]
) -> Evidence | None:
    """The start of a suspect's search that fits best; None where these frames cannot have it."""
    best: Evidence | None = None
    for effect in starts(kind):
        hinted = {p.name: hints[p.name] for p in kind.parameters() if p.name in hints}
        if hinted:
            effect = dataclasses.replace(effect, **hinted)
        found = _held(case, effect, references)
        if found is not None and (best is None or found.score > best.score):
            best = found
    return best


def _held(
    case: Case,
    effect: Effect,
    references: dict[int, Observation],
) -> Evidence | None:
    shown = signature(effect, case.known, others=case.known.effects, references=references)
    if shown is None:
        return None
    return hold(shown, case.fitting.turned, case.fit_left)


def _adapt(case: Case, found: Evidence, references: dict[int, Observation]) -> Evidence:
    """Simulate at the strength it seems to have, until it has it."""
    best = found
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
        shown = _held(case, scaled(found.effect, factor), references)
        if shown is None or shown.effect == best.effect:
            break
        tried.append((factor, shown.amount))
        response = response_of(tried, response)
        if shown.score > best.score or not RIGHT[0] <= best.amount <= RIGHT[1]:
            best = shown
    return best


def _as_it_is(case: Case, found: Evidence) -> Candidate:
    """A suspect that was not followed, at the amount that least squares gives it."""
    return candidate(case, found.signature, case.known.base, found.absorbed, found.amount)
