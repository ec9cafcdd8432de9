"""Calibrate the camera once more, with a suspect in it from the start."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from analysis.gap.calibrate.fit import FINAL_SEEDS, around
from analysis.gap.calibrate.refine import MOST_STEPS, Refined, as_shown, refine, refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.measure.case import MISFIT, Candidate, Case, candidate
from analysis.gap.measure.signature import scaled, signature
from analysis.gap.ready.hints import DirectReading
from analysis.gap.suspects.beginnings import choice_of, of_other_strengths, with_more_strengths
from analysis.gap.suspects.fit_scattering import settled
from analysis.gap.suspects.likelihood import cost
from analysis.gap.suspects.mend import Search, Tried, likelier, mended
from analysis.gap.suspects.starting_points import StartingPoints
from sensor.effect import Effect, Stage

ANEW_STEPS = 5
"""Steps of a calibration with a suspect, at most, where the camera was calibrated before."""

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

BEHIND_WITH_CHOICES = 4.0
"""The same of one that may be chosen otherwise. A filter with soft weights left 3.1 times as much
as a filter in time by hard ones, and 0.7 times by its own."""

WORTH_MENDING = 0.7
"""Part of the misfit without a suspect, each by its own errors, from which its way of counting and
its strength are not mended: half the strength of a filter leaves a fourth. What is no cause left
0.76 of it after seven ways, and mending took as long as these."""

STRONGER = (1.0, 2.0)
"""Times the strength that a converter's errors seem to have by means, or a search for them begins
with. Errors of 0.0415 of a unit element left 0.54 of the misfit at 0.03, and 0.43 at 0.06."""

LED_NOWHERE = 0.9
"""Part of the misfit without a suspect that a pursuit of it must not leave."""


def anew(
    case: Case,
    found: Candidate,
    first: Effect,
    told: DirectReading | None = None,
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
    exact, start = bool(told and told.exact), told.base if told else None
    coded = found.effect.stage is Stage.TRANSPORT  # and hides how far the camera is
    effects = (*known.effects, found.effect)
    as_found = found, refined(found.base, case.fit_seen, scenery, effects)
    scatters, fits = _scatters(case, *as_found), as_found[1].misfit <= ENOUGH
    if scatters and not exact:
        return _settled(case, found)
    if scatters and fits:
        return _as_settled(case, found, start)
    effect, base = found.effect, found.base
    if start or found.misfit > LED_NOWHERE * case.misfit:
        effect, base = first, start or known.base
    if start:
        # the light was changed for the effect beside another camera
        scenery = (told and told.scenery) or known.scenery

    def calibrated(begin: Base, with_it: Effect) -> Tried:
        fitted = refine(
            begin,
            case.fit_seen,
            scenery,
            (*known.effects, with_it),
            steps=MOST_STEPS if exact or coded else ANEW_STEPS,
            tuned="" if exact else found.name,
        )
        one = _scored(case, found, fitted.base, fitted.effects[-1])
        return as_found if one is None else (one, fitted)

    def off(now: Refined) -> bool:
        most = min(BEHIND * to_beat, WORTH_MENDING * case.bare.misfit)
        return not exact and MISFIT < now.misfit <= most

    points = StartingPoints(
        case=case,
        scenery=scenery,
        as_found=as_found,
        base=base,
        effect=effect,
        told=told,
        tuned=not exact,
    )
    behind = BEHIND_WITH_CHOICES if choice_of(effect) else BEHIND
    best = as_found if fits else _followed(points, calibrated, behind * to_beat)
    if not exact:
        best = with_all_strengths(case, best, calibrated)
    if effect.stage is Stage.PROCESSING:
        search = Search(seen=case.fit_seen, scenery=scenery, calibrated=calibrated, off=off)
        best = mended(best, search)
    if best is not as_found and start and told and told.scenery:
        return _by_its_own_errors(told.scenery, *best)
    if exact and _scatters(case, *best):
        return _by_its_own_errors(scenery, *best)
    return best[0]


def _by_its_own_errors(scenery: Scenery, found: Candidate, fitted: Refined) -> Candidate:
    """A suspect with the camera that was calibrated with it: under another light than the model's
    it is no change of the model, and by the errors of one in which bodies hardly differ nothing
    tells well what makes them differ.
    """
    model = around(fitted.base, as_shown(fitted, scenery), fitted.effects)
    off = fitted.misfit - 1.0
    return dataclasses.replace(
        found, model=model, scenery=model.scenery, misfit=fitted.misfit, off=off
    )


def _followed(
    points: StartingPoints, calibrated: Callable[[Base, Effect], Tried], hopeless: float
) -> Tried:
    """The best of all ways, up to the first that fits; a hopeless one is the last.

    Args:
        points: where to begin.
        calibrated: the camera with the suspect that steps from there lead to.
        hopeless: misfit beyond which no other point is begun from.
    """
    best = points.as_found
    stages = (
        points.of_what_is_hidden,
        points.behind_a_codec,
        points.by_counting,
        points.by_every_rule,
        points.by_choosing,
        points.once_more,
    )
    for beginnings in stages:
        for base, effect in beginnings(best):
            best = likelier(best, calibrated(base, effect))
            if best[1].misfit <= ENOUGH or best[1].misfit > hopeless:
                return best
    return best


def with_all_strengths(
    case: Case, best: Tried, calibrated: Callable[[Base, Effect], Tried]
) -> Tried:
    """With strengths that are off as well, where that is likelier: a search that began with one of
    them found what it alone can do.
    """
    others = with_more_strengths(best[1].effects[-1])
    tried = [best, *(calibrated(best[1].base, more) for more in others)]
    return min(tried, key=lambda one: cost(case, one[0])) if others else best


def with_its_scatter(case: Case, found: Candidate) -> Candidate | None:
    """A suspect whose pattern lies elsewhere in every body, fitted in the space of a model that has
    it; None for one that makes no bodies differ.

    Args:
        case: the capture.
        found: the suspect about as strong as it seems by the errors of a model without it.
    """
    own = (
        refined(found.base, case.fit_seen, found.scenery, (*case.known.effects, effect))
        for effect in _as_strong_as_may_be(found.effect)
    )
    scatter = [one for one in own if _scatters(case, found, one)]
    if not scatter:
        return None
    likeliest = min(scatter, key=lambda one: one.deviance)
    return _settled(case, dataclasses.replace(found, effect=likeliest.effects[-1]))


def _as_strong_as_may_be(effect: Effect) -> list[Effect]:
    """A suspect as strong as it seems; one of the converter as another kind of it, and stronger.

    What is wrong with codes moves means up and down from one code to the next, in every body
    another way: means tell neither how wrong they are nor of what kind.
    """
    if effect.stage is not Stage.ADC:
        return [effect]
    kinds = [effect, *of_other_strengths(effect)]
    return [scaled(one, factor) for one in kinds for factor in STRONGER]


def _scatters(case: Case, found: Candidate, own: Refined) -> bool:
    """Whether a suspect leaves much by the errors of a model without it, and not by its own."""
    # what is done to pictures is the same in every body; what was led astray leaves more than there
    # was, by any errors; and few twins make less of what neither model has
    if found.effect.stage in (Stage.PROCESSING, Stage.TRANSPORT):
        return False
    less = own.misfit < SCATTERS * min(found.misfit, case.misfit)
    return less and own.misfit < SCATTERS * case.bare.misfit


def _settled(case: Case, found: Candidate) -> Candidate:
    """A suspect that makes bodies differ, in the space of a model that has it."""
    model, off = settled(case, found.base, found.effect)
    if off > LEAVES_SOME:
        # one of its strengths may have taken up what another one does
        others = (settled(case, found.base, one) for one in of_other_strengths(found.effect))
        model, off = min([(model, off), *others], key=lambda one: one[1])
    one = _scored(case, found, model.base, model.effects[-1])
    return found if one is None else dataclasses.replace(one, model=model, off=off)


def _as_settled(case: Case, found: Candidate, start: Base | None) -> Candidate:
    """A suspect that makes bodies differ, as it is told to the last digit, with a camera that is
    fitted from where it begins with it: by errors as wide as where bodies differ much any other
    camera seems to fit as well.
    """
    model, off = settled(case, start or found.base, found.effect, tuned=False)
    one = _scored(case, found, model.base, found.effect)
    return found if one is None else dataclasses.replace(one, model=model, off=off)


def _scored(case: Case, found: Candidate, base: Base, effect: Effect) -> Candidate | None:
    """A suspect with another strength and another camera; None where that cannot be simulated."""
    shown = signature(effect, case.known, base=base, seeds=FINAL_SEEDS)
    return None if shown is None else candidate(case, shown, found.absorbed)
