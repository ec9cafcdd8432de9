"""Which effect: every suspect at the strength that fits, scored on frames that did not fit it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from analysis.gap.camera.handles import does_nothing
from analysis.gap.measure.case import MISFIT, Candidate, Case, candidate
from analysis.gap.measure.signature import Evidence, Signature, comes_in_steps, hold
from analysis.gap.ready.hints import DirectReading, Hints
from analysis.gap.suspects.adapt import Adapted, adapted
from analysis.gap.suspects.anew import OFF, anew, with_its_scatter
from analysis.gap.suspects.beginnings import is_a_scale
from analysis.gap.suspects.first_look import IN_THE_PICTURE, in_range
from analysis.gap.suspects.likelihood import CLEAR_SCORE, judged
from analysis.gap.suspects.pursue import pursue
from sensor.effect import Effect, Stage

WORTH_A_LOOK = 6.0
"""A suspect that takes less off chi-squared is not followed."""

ADAPTED = 7
"""Suspects that are simulated again at the strength that fits, best first, at most."""

FINALISTS = 3
"""Suspects that are followed, with those of which frames tell parameters."""

LIKELIEST = 2
"""Finalists of which frames tell nothing, where none of those of which they do fits."""

HOPELESS = 0.02
"""Part of the best score, as both were seen at first, below which no strength is looked for: none
makes ten times as much of a suspect, which it would need to be a finalist."""

NEAR = 0.2
"""A suspect with less than this part of the best score is no finalist."""

RIVAL = 0.5
"""Part of the best score from which another one is its rival."""

NEARLY_ALL_OF_IT = 0.15
"""Part of the misfit without a suspect that is left by one of which the frames tell, and from which
no other one is calibrated anew."""

FAR_WORSE = 3.0
"""Times the misfit without a suspect from which the camera is not calibrated anew with it."""

BY_BODY = IN_THE_PICTURE | {Stage.ADC}
"""Stages whose effects may be drawn anew for every body."""

NOTHING_TOLD: Mapping[str, DirectReading] = MappingProxyType({})


def attribute(
    case: Case,
    shown: Iterable[Signature],
    watch: Callable[[str], None] = lambda name: None,
    *,
    told: Mapping[str, DirectReading] = NOTHING_TOLD,
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
    # beside another effect the frames' own word is one among others
    evident = [
        e for e in first if e.name in told and (not case.known.effects or e.score > WORTH_A_LOOK)
    ]
    at_strength = _at_strength(case, [e for e in first if e not in evident], watch)
    by_word: list[Candidate] = []
    for found in evident:
        watch(found.name)
        so_far = min((c.misfit for c in by_word), default=np.inf)
        by_word.append(_as_told(case, found, told[found.name], so_far))
    by_search = _pursued(case, at_strength, by_word, watch)
    # of a suspect that was followed that is what counts
    unique = {one.name: _as_it_is(case, one) for one in first}
    unique |= {one.nearest.name: _as_adapted(case, one) for one in at_strength}
    unique |= {c.name: c for c in [*by_word, *by_search]}
    scattered: list[Candidate] = []
    if _unexplained(case) >= CLEAR_SCORE and not any(map(_fits, unique.values())):
        scattered = _scattered(case, _untold(unique, told), watch)
    in_the_end = {c.name: c for c in [*by_word, *by_search, *scattered]}
    unique |= {c.name: c for c in judged(case, list(in_the_end.values()), _unexplained(case))}
    by_steps = _by_lost_bits(unique, told)
    merits = (_no_merit(c) if c.name in by_steps else _if_it_does(c) for c in unique.values())
    return sorted(merits, key=lambda c: -c.score)


def _untold(found: Mapping[str, Candidate], told: Mapping[str, DirectReading]) -> list[Candidate]:
    """Suspects that may be fitted better than they are: not what frames tell to the last digit, nor
    what else is wrong with codes where they tell that some are lost.

    Args:
        found: suspects by name.
        told: those of which the frames tell parameters.
    """
    exact = {name for name, one in told.items() if one.exact}
    by_steps = _by_lost_bits(found, told)
    return [one for name, one in found.items() if name not in exact and name not in by_steps]


def _by_lost_bits(
    found: Mapping[str, Candidate], told: Mapping[str, DirectReading]
) -> frozenset[str]:
    """Names of suspects that may only be seeing lost bits: what else is wrong with codes, where the
    frames tell that some never occur. Unequal steps of a converter scored 47,857 for one lost bit
    that had 44,869.

    Args:
        found: suspects by name.
        told: those of which the frames tell parameters.
    """
    exact = {name for name, one in told.items() if one.exact}
    of_codes = frozenset(name for name, one in found.items() if one.effect.stage is Stage.ADC)
    return of_codes - exact if of_codes & exact else frozenset()


def _fits(found: Candidate) -> bool:
    """Whether a suspect leaves no more than chance does, by the errors of the model without it or
    by its own.
    """
    return found.misfit <= MISFIT or found.off <= OFF


def _scattered(
    case: Case, found: Iterable[Candidate], watch: Callable[[str], None]
) -> list[Candidate]:
    """Suspects whose pattern lies elsewhere in every body: the errors of a model without them call
    most of them small, so that no search by scores comes to them.

    Args:
        case: the capture.
        found: suspects.
        watch: told whose turn it is.
    """
    made = []
    for one in found:
        drawn = one.effect.stage in BY_BODY and not comes_in_steps(one.effect)
        if drawn and one.score > WORTH_A_LOOK and one.model is None:
            watch(one.name)
            made.append(with_its_scatter(case, one))
    return [one for one in made if one is not None]


def _as_told(case: Case, found: Evidence, told: DirectReading, to_beat: float) -> Candidate:
    """A suspect calibrated with what frames tell of it; told otherwise where that leaves something.

    Args:
        case: the capture.
        found: the suspect, as it begins.
        told: what the frames tell of it.
        to_beat: misfit of the best of those that were calibrated before.
    """
    best = _by(told, anew(case, _as_it_is(case, found), found.effect, told, to_beat))
    while told.instead is not None and best.misfit > MISFIT:
        told = told.instead
        first = as_hinted(found.effect, told.hints)
        other = anew(case, best, first, told, min(to_beat, best.misfit))
        best = min(best, _by(told, other), key=lambda one: one.misfit)
    return best


def as_hinted(effect: Effect, hints: Hints) -> Effect:
    """An effect with what is told of it, each figure inside its range: blocks of a codec jump as
    traps would in more pixels than there are.
    """
    return dataclasses.replace(effect, **in_range(type(effect), hints))


def _by(told: DirectReading, found: Candidate) -> Candidate:
    """A suspect with the errors of what is told of it to the last digit."""
    return dataclasses.replace(found, told=told.errors if told.exact else None)


def _at_strength(
    case: Case, possible: Sequence[Evidence], watch: Callable[[str], None]
) -> list[Adapted]:
    """Suspects that are worth a look, each at the strength that fits, best first."""
    likely = [e for e in possible if not too_much(e)]
    worth_it = max(WORTH_A_LOOK, HOPELESS * max((e.score for e in likely), default=0.0))
    found = []
    for one in likely[:ADAPTED]:
        if one.score > worth_it:
            watch(one.name)
            found.append(adapted(case, one))
    return sorted(found, key=lambda one: -one.clearest.score)


def _pursued(
    case: Case,
    at_strength: Sequence[Adapted],
    by_word: Sequence[Candidate],
    watch: Callable[[str], None],
) -> list[Candidate]:
    """The finalists, each followed; where none fits, those that lead are calibrated anew.

    Args:
        case: the capture.
        at_strength: suspects, best first.
        by_word: those of which the frames tell, calibrated with them.
        watch: told whose turn it is.
    """
    # what frames seem to tell may be another effect's doing, so the likeliest are followed as well
    least = LIKELIEST if all(c.misfit > MISFIT for c in by_word) else 0
    likely = [a for a in at_strength if a.clearest.score > NEAR * at_strength[0].clearest.score]
    finalists = likely[: max(FINALISTS - len(by_word), least)]
    found = []
    for one in finalists:
        watch(one.nearest.name)
        found.append(followed(case, one))
    # the strongest effect is the first, and calibration has known it since; and who leaves so
    # little is the cause, or its model is not quite right
    if case.known.effects or any(c.misfit < NEARLY_ALL_OF_IT * case.misfit for c in by_word):
        return found
    most = max((c.score for c in found), default=0.0)
    for place, one in enumerate(finalists):
        if any(c.misfit <= MISFIT for c in [*by_word, *found]):
            break
        pursued = found[place]
        # a pursuit may lead nowhere, and it may lead past the one that looked best before
        leads = one.clearest.score > RIVAL * finalists[0].clearest.score
        rival = leads or pursued.score > RIVAL * most
        if rival and pursued.misfit <= FAR_WORSE * case.misfit:
            watch(one.nearest.name)
            so_far = min((c.misfit for c in [*by_word, *found[:place]]), default=np.inf)
            found[place] = anew(case, pursued, one.nearest.effect, to_beat=so_far)
    return found


def _unexplained(case: Case) -> float:
    """Chi-squared beyond what is expected."""
    return float(np.square(case.fit_left).sum() - case.fitting.spread.expected.sum())


def _if_it_does(found: Candidate) -> Candidate:
    """A suspect, with no merit where it does nothing at the strength that was found."""
    return _no_merit(found) if does_nothing(found.effect) else found


def _no_merit(found: Candidate) -> Candidate:
    return dataclasses.replace(found, score=0.0)


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
    a_scale = any(map(is_a_scale, found.effect.parameters()))
    return comes_in_steps(found.effect) and not a_scale and found.amount < LEAST_OF_A_STEP


def followed(case: Case, found: Adapted) -> Candidate:
    """A suspect pursued, or as it was seen at first where that leaves less.

    Every try of a pursuit has noise of its own, in its camera as well. Where an effect hardly
    stands out of the frames, a pursuit follows that.

    Args:
        case: the capture.
        found: the suspect.
    """
    pursued = pursue(case, found.nearest)
    if comes_in_steps(found.effect):
        return pursued
    return min(pursued, _as_adapted(case, found), key=lambda one: one.misfit)


def _as_adapted(case: Case, found: Adapted) -> Candidate:
    """A suspect at its strength, by its clearest signature."""
    return dataclasses.replace(_as_it_is(case, found.clearest), effect=found.effect)


def _as_it_is(case: Case, found: Evidence) -> Candidate:
    """A suspect that was not followed, at the amount that least squares gives it; one that comes in
    steps and would do too much is as it would be.
    """
    amount = 1.0 if too_much(found) else found.amount
    return candidate(case, found.signature, found.absorbed, amount)
