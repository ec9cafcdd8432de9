"""Which effect: every suspect at the strength that fits, scored on frames that did not fit it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from analysis.gap.measure.case import Candidate, Case, candidate
from analysis.gap.measure.signature import (
    Evidence,
    Signature,
    hold,
    scaled,
    signature,
)
from analysis.gap.ready.hints import Told
from analysis.gap.suspects.anew import MISFIT, anew
from analysis.gap.suspects.likelihood import judged
from analysis.gap.suspects.pursue import LONG, pursue
from sensor.effect import Effect

ROUNDS = 3
"""How often a suspect is simulated again at the strength that it seems to have."""

RIGHT = (0.75, 1.33)
"""Strengths this near to each other need no further round."""

USUAL_RESPONSE = 1.5
"""Power of the strength with which a signature grows, until two strengths have been tried: noise
shows as its variance, what bends and blurs as itself."""

RESPONSES = (0.5, 4.0)
"""Powers that are believed."""

NEXT_TO_NOTHING = 1e-3
"""Part of what the capture has that no strength shows less of."""

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
    adapted.sort(key=lambda one: -one.clearest.score)
    likely = [a for a in adapted if a.clearest.score > NEAR * adapted[0].clearest.score]
    candidates: list[Candidate] = []
    for found in evident:
        watch(found.name)
        candidates.append(anew(case, _as_it_is(case, found), found.effect, told[found.name]))
    # what frames seem to tell may be another effect's doing, so the likeliest are followed as well
    least = LIKELIEST if all(c.misfit > MISFIT for c in candidates) else 0
    finalists = likely[: max(FINALISTS - len(evident), least)]
    for one in finalists:
        watch(one.nearest.name)
        candidates.append(followed(case, one))
    expected = float(case.fitting.spread.expected.sum())
    without = float(np.square(case.fit_left).sum()) / expected
    most = max((c.score for c in candidates[len(evident) :]), default=0.0)
    for place, one in enumerate(finalists, start=len(evident)):
        found = one.clearest
        # the strongest effect is the first, and calibration has known it since
        if case.known.effects or any(c.misfit <= MISFIT for c in candidates):
            break
        far = candidates[place].misfit > FAR_WORSE * without
        # a pursuit may lead nowhere, and it may lead past the one that looked best before
        rival = (
            found.score > RIVAL * likely[0].clearest.score or candidates[place].score > RIVAL * most
        )
        if rival and not far:
            watch(found.name)
            candidates[place] = anew(case, candidates[place], one.nearest.effect)
    # calibrated with its own suspect, a camera's errors may be others: scores say little of that
    unexplained = expected * (without - 1.0)
    candidates = judged(case, candidates, unexplained)
    done = {c.name for c in candidates}
    candidates += [_as_adapted(case, a) for a in adapted if a.effect.name not in done]
    done = {c.name for c in candidates}
    candidates += [_as_it_is(case, e) for e in first if e.name not in done]
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
    return _comes_in_steps(found.effect) and not a_scale and found.amount < LEAST_OF_A_STEP


def _comes_in_steps(effect: Effect) -> bool:
    return scaled(effect, 0.5) == effect


@dataclass(frozen=True, kw_only=True, eq=False)
class _Adapted:
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


def _adapt(case: Case, found: Evidence) -> _Adapted:
    """Simulate at the strength it seems to have, until it has it."""
    here = signature(found.effect, case.known) if case.known.effects else None
    clearest = found if here is None else _held(case, here)
    tried = {1.0: clearest}
    aim = _aim(case, tried, clearest)
    for _ in range(ROUNDS):
        if aim == 0 or any(RIGHT[0] <= aim / factor <= RIGHT[1] for factor in tried):
            break
        moved = signature(scaled(found.effect, aim), case.known)
        if moved is None or moved.effect in {one.effect for one in tried.values()}:
            break
        tried[aim] = _held(case, moved)
        clearest = max(tried.values(), key=lambda one: one.score)
        aim = _aim(case, tried, clearest)
    near = min(tried, key=lambda factor: abs(np.log(factor / aim)) if factor * aim > 0 else np.inf)
    return _Adapted(effect=scaled(found.effect, aim), nearest=tried[near], clearest=clearest)


def _aim(case: Case, tried: Mapping[float, Evidence], clearest: Evidence) -> float:
    """The strength, as a factor, with which an effect shows as much of its clearest signature as
    the capture has: what each strength shows of it is known far better than the capture is.

    Args:
        case: the capture.
        tried: the effect by factor of its strength.
        clearest: one of them.
    """
    own = next(factor for factor, one in tried.items() if one is clearest)
    amount = clearest.amount
    if amount <= 0:
        return -own * min(-amount, 4.0)
    space = case.fitting.turned.space
    template = clearest.left[: len(space.families)] / clearest.norm
    # below a threshold there is nothing, whatever the noise says
    known = [
        (
            factor,
            max(float(space.vector(*one.signature.plain) @ template), NEXT_TO_NOTHING * amount),
        )
        for factor, one in tried.items()
        if factor * own > 0
    ]
    (factor, part), *others = sorted(known, key=lambda one: abs(np.log(one[1] / amount)))
    response = USUAL_RESPONSE
    if others:
        beyond = [one for one in others if (one[1] > amount) is not (part > amount)]
        other, other_part = (beyond or others)[0]
        response = float(np.clip(np.log(part / other_part) / np.log(factor / other), *RESPONSES))
    return factor * float(np.clip((amount / part) ** (1.0 / response), 0.1, 8.0))


def followed(case: Case, adapted: _Adapted) -> Candidate:
    """A suspect pursued, or as it was seen at first where that leaves less.

    Every try of a pursuit has noise of its own, in its camera as well. Where an effect hardly
    stands out of the frames, a pursuit follows that.

    Args:
        case: the capture.
        adapted: the suspect.
    """
    pursued = pursue(case, adapted.nearest)
    if _comes_in_steps(adapted.effect):
        return pursued
    return min(pursued, _as_adapted(case, adapted), key=lambda one: one.misfit)


def _as_adapted(case: Case, adapted: _Adapted) -> Candidate:
    """An adapted suspect, by its clearest signature."""
    found = _as_it_is(case, adapted.clearest)
    return dataclasses.replace(found, effect=adapted.effect)


def _as_it_is(case: Case, found: Evidence) -> Candidate:
    """A suspect that was not followed, at the amount that least squares gives it; one that comes in
    steps and would do too much is as it would be.
    """
    amount = 1.0 if too_much(found) else found.amount
    return candidate(case, found.signature, case.known.base, found.absorbed, amount)
