"""Calibrate the camera once more, with a suspect in it from the start."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from analysis.gap.calibrate.counting import counted
from analysis.gap.calibrate.fit import FINAL_SEEDS
from analysis.gap.calibrate.refine import MOST_STEPS, Refined, refine, refined
from analysis.gap.camera.base import Base, channels_alike
from analysis.gap.look.arithmetic import (
    IN_FRACTIONS,
    OF_QUARTERS,
    OF_WHOLE_SAMPLES,
)
from analysis.gap.measure.case import MISFIT, Candidate, Case, candidate
from analysis.gap.measure.signature import signature
from analysis.gap.ready.hints import Told
from analysis.gap.suspects.beginnings import (
    as_dark,
    choices,
    every_choice,
    of_other_strengths,
    uncoded,
)
from analysis.gap.suspects.mend import Search, Tried, likelier, mended
from analysis.gap.suspects.settle import settled
from sensor.effect import Effect, Stage

ANEW_STEPS = 5

ENOUGH = 1.05
"""Misfit, by its own errors, from which no other way is gone with a suspect."""

SCATTERS = 0.5
"""Part of the misfit by the errors of a model without a suspect that is left by its own, where it
makes bodies differ."""

OFF = 1.0
"""G of the frames that fit beyond which such a suspect does not fit."""

LEAVES_SOME = 0.2
"""The same from which its other strengths are tried: twice what nulls leave."""

BEHIND = 2.0
"""Times the misfit of a suspect that was calibrated before, from which one that leaves more after
its likeliest way is not sent on any other."""

LED_NOWHERE = 0.9
"""Part of the misfit without a suspect that a pursuit of it must not leave."""


def anew(
    case: Case,
    found: Candidate,
    first: Effect,
    told: Told | None = None,
    to_beat: float = np.inf,
) -> Candidate:
    """Calibrate the camera with the suspect in it, its parameters along with the base.

    Where a suspect is strong, the base that was calibrated without it is far from the camera, and
    directions that were read there lead astray.

    Args:
        case: the capture.
        found: the suspect as it was fitted so far.
        first: as the search for it began; taken up again where the pursuit led nowhere.
        told: what the frames tell of it.
        to_beat: misfit of the best of those that were calibrated before.
    """
    known, scenery = case.known, found.scenery

    def against(base: Base, effect: Effect) -> Refined:
        """By its own errors: what makes figures scatter leaves much by those of others."""
        return refined(base, case.fit_seen, scenery, (*known.effects, effect))

    as_found = found, against(found.base, found.effect)
    best = as_found
    tuned = not (told and told.exact)
    if tuned and _scatters(case, *as_found):
        return _settled(case, found)
    if best[1].misfit <= ENOUGH:
        return found
    effect, base = found.effect, found.base
    start = told.base if told else None
    if start or found.misfit > LED_NOWHERE * case.misfit:
        effect, base = first, start or known.base
    if start:
        # the light was changed for the effect beside another camera
        scenery = known.scenery

    def calibrated(begin: Base, with_it: Effect) -> Tried:
        fitted = refine(
            begin,
            case.fit_seen,
            scenery,
            (*known.effects, with_it),
            steps=ANEW_STEPS if tuned else MOST_STEPS,
            tuned=found.name if tuned else "",
        )
        one = _scored(case, found, fitted.base, fitted.effects[-1])
        return as_found if one is None else (one, fitted)

    def ways() -> Iterator[tuple[Base, Effect]]:
        """Where to begin, the likeliest first."""
        coloured = "G" in base.channels
        even = channels_alike(base) if coloured else base
        coded = effect.stage is Stage.TRANSPORT
        chosen = [effect]
        if tuned or coded:
            chosen = every_choice(effect, told.hints if told else None)
        likely = effect
        if not start and (len(chosen) > 1 if coded else not tuned):
            tried = [against(uncoded(even), one) for one in chosen]
            begun = min(tried, key=lambda one: one.misfit)
            likely = begun.effects[-1]
            if not tuned:
                yield as_dark(against(even, likely), case.fit_seen), likely
            for rule in rules(begun.base.arithmetic) if coded else [begun.base.arithmetic]:
                yield dataclasses.replace(begun.base, arithmetic=rule), likely
        if not coloured:
            yield from from_where_it_is(likely)
            return
        if best is as_found or best[1].misfit > MISFIT:
            yield counted(against(even, likely), case.fit_seen, scenery), likely
            yield from from_where_it_is(likely)
        if best is not as_found:
            yield channels_alike(best[1].base), best[1].effects[-1]

    def rules(first: int) -> list[int]:
        """Rules by which the camera may count, beginning with one."""
        others = [rule for rule in (IN_FRACTIONS, OF_WHOLE_SAMPLES, OF_QUARTERS) if rule != first]
        return [first, *(rule for rule in others if rule in scenery.rules)]

    def from_where_it_is(effect: Effect) -> Iterator[tuple[Base, Effect]]:
        """The same without a change of the camera's figures."""
        as_it_was = base is found.base and effect == found.effect
        begun = as_found[1] if as_it_was else against(base, effect)
        as_counted = counted(begun, case.fit_seen, scenery)
        yield as_counted, effect
        # far from the camera its arithmetic cannot be seen, so all ways are gone
        for rule in rules(as_counted.arithmetic)[1:]:
            yield dataclasses.replace(base, arithmetic=rule), effect
        for other in choices(effect):
            # another rule by which colours are filled in shows another way of counting
            if effect.stage is Stage.PROCESSING:
                yield counted(against(base, other), case.fit_seen, scenery), other
            else:
                yield as_counted, other

    for way in ways():
        best = likelier(best, calibrated(*way))
        if best[1].misfit <= ENOUGH or best[1].misfit > BEHIND * to_beat:
            break

    def off(now: Refined) -> bool:
        return tuned and MISFIT < now.misfit <= BEHIND * to_beat

    if effect.stage is Stage.PROCESSING:
        search = Search(seen=case.fit_seen, scenery=scenery, calibrated=calibrated, off=off)
        best = mended(best, search)
    return best[0]


def elsewhere(case: Case, found: Candidate) -> Candidate | None:
    """A suspect whose pattern lies elsewhere in every body, fitted in the space of a model that has
    it; None for one that makes no bodies differ.

    Args:
        case: the capture.
        found: the suspect about as strong as it seems by the errors of a model without it.
    """
    effects = (*case.known.effects, found.effect)
    own = refined(found.base, case.fit_seen, found.scenery, effects)
    return _settled(case, found) if _scatters(case, found, own) else None


def _scatters(case: Case, found: Candidate, own: Refined) -> bool:
    """Whether a suspect leaves much by the errors of a model without it, and not by its own."""
    # what is done to pictures is the same in every body; and what was led astray leaves more than
    # there was, by any errors
    of_bodies = found.effect.stage not in (Stage.PROCESSING, Stage.TRANSPORT)
    return of_bodies and own.misfit < SCATTERS * min(found.misfit, case.misfit)


def _settled(case: Case, found: Candidate) -> Candidate:
    """A suspect that makes bodies differ, in the space of a model that has it."""
    model, off = settled(case, found.base, found.effect)
    if off > LEAVES_SOME:
        # one of its strengths may have taken up what another one does
        others = (settled(case, found.base, one) for one in of_other_strengths(found.effect))
        model, off = min([(model, off), *others], key=lambda one: one[1])
    one = _scored(case, found, model.base, model.effects[-1])
    return found if one is None else dataclasses.replace(one, model=model, off=off)


def _scored(case: Case, found: Candidate, base: Base, effect: Effect) -> Candidate | None:
    """A suspect with another strength and another camera; None where that cannot be simulated."""
    shown = signature(effect, case.known, base=base, seeds=FINAL_SEEDS)
    return None if shown is None else candidate(case, shown, base, found.absorbed)
