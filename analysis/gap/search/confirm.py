"""The model with a suspect added, and whether that is its own doing."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from analysis.gap.calibrate.finer_light import under_other_light
from analysis.gap.calibrate.fit import Fit
from analysis.gap.calibrate.hidden import lost_its_spread, part_of_the_offsets
from analysis.gap.calibrate.refine import FITS_MISFIT, as_shown, refine, refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.handles import does_nothing
from analysis.gap.measure.case import MISFIT, Candidate
from analysis.gap.measure.measured import Measured
from analysis.gap.ready.setting import Setting, halves
from analysis.gap.search.choice import DRAWN, LEAST_SCORE, LEAST_SHRINK, SIGNIFICANCE, Choice
from analysis.gap.search.closing import CERTAIN, accounts, closed, nothing_left, too_wide
from analysis.gap.search.step import Step, Watch, around_it, nearer, step_to
from analysis.gap.suspects.anew import ANEW_STEPS, anew
from analysis.gap.suspects.beginnings import chosen_otherwise, kind_of, of_other_strengths
from analysis.gap.suspects.recount import recounted
from sensor.effect import Effect

SECOND_LOOK = 0.2
"""Part of the best score from which another suspect is tried where the best leaves something: one
effect that closes the gap alone is likelier than two that do it together."""

MOST_RIVALS = 2
"""Such suspects, by their scores, that are tried."""

MUCH = 0.5
"""Part of a gap that is closed from which calibration may not have come to its end: a lateral
colour of somebody else closed 0.76 of it beside the camera as found, and 0.92 beside its own."""

TOO_MUCH_LEFT = 2.0
"""Misfit from which a rival is not tried, unless it makes bodies differ: it would leave far more
than chance."""

FAR_LESS = 0.5
"""Part of the misfit of the best that such a rival leaves all the same: beside a level that wanders
grains of dust were likelier than the distortion that it was, and left ten times as much of it."""

NEARLY_CLOSED = 1e-3
"""What a rival may leave where the best leaves something beyond doubt."""


def with_it(setting: Setting, model: Fit, now: Measured, choice: Choice, watch: Watch) -> Step:
    """The step that the best suspect makes, whatever it leaves.

    One that fits as a signature, so that no camera was calibrated with it, may not fit as part of a
    camera: then one is. And of one that closes most of a gap what is left may be that calibration
    had not come to its end.

    Args:
        setting: the capture.
        model, now: the camera without the suspect, and the capture against it.
        choice: the suspect.
        watch: told what is being done.
    """
    found = choice.best
    watch(f"confirming {found.name}")
    step = _as_found(setting, model, choice)
    if not step.ends and found.model is None and found.misfit <= MISFIT:
        again = anew(now.case, found, found.effect)
        if again is not found:
            # what it was chosen for is its score as it was found
            moved = dataclasses.replace(again, score=found.score, misfit=found.misfit)
            choice = dataclasses.replace(choice, best=moved)
            step = _nearer_with_it(step, _as_found(setting, model, choice))
    much = closed(now.held.total, step.left.held.total) >= MUCH
    if step.ends or not much:
        return step
    for base in _beginnings(step, model):
        step = _nearer_with_it(step, _calibrated(setting, step, step.model.effects, base))
        if step.ends:
            return step
    return step if found.told else _with_other_choices(setting, step)


def _beginnings(step: Step, model: Fit) -> Iterator[Base]:
    """Where calibration with a suspect begins: a pursuit may have led the camera astray, and the
    one before it not. And what is wrong at edges hides what light is like within pixels.

    Args:
        step: with the suspect.
        model: the camera without it.
    """
    found, scenery = step.model.base, step.model.scenery
    yield found
    yield model.base
    if lost_its_spread(found, scenery):
        yield part_of_the_offsets(dataclasses.replace(found, dark_uneven=0.0), scenery)
    yield from under_other_light(found, scenery.light)


def _with_other_choices(setting: Setting, step: Step) -> Step:
    """The step with other choices or another strength of the suspect, one after the other, while
    that leaves less.

    A choice is made where scores tell it apart, and what they tell apart is less than what frames
    do: a filter that weighs all colours together fits nearly as well as one that weighs each. And a
    converter of somebody else's, which weighs in two steps, was by its score one that compares; as
    such it left G 0.13, and as one that weighs nothing (p = 0.95).
    """
    tried = {kind_of(step.model.effects[-1])}
    while not step.ends:
        *before, effect = step.model.effects
        every = (*chosen_otherwise(effect), *of_other_strengths(effect))
        others = [one for one in every if kind_of(one) not in tried]
        tried |= {kind_of(one) for one in others}
        best = step
        for other in others:
            again = _calibrated(setting, step, (*before, other), step.model.base)
            best = _nearer_with_it(best, again)
            if best.ends:
                break
        if best is step:
            break
        step = best
    return step


def _nearer_with_it(step: Step, calibrated: Step) -> Step:
    """The calibrated step if it leaves less and the suspect does something in it; else `step`."""
    return step if _is_gone(calibrated) else nearer(step, calibrated)


def _is_gone(step: Step) -> bool:
    """Whether the effect that was added does nothing once the camera is calibrated with it."""
    return does_nothing(step.model.effects[-1])


def _as_found(setting: Setting, model: Fit, choice: Choice) -> Step:
    """The step with the camera that the search for the suspect leads to.

    A search ends where scores tell suspects apart. Its amounts are least squares along directions
    that were read beside the camera without it, under light as the frames show it to that one, and
    the camera may still be far from its end: a gamma came out with 70 % of its bend, beside a gain
    that was 4 % too low. So where both fit the camera is calibrated with the suspect, under
    light as the frames show it to both, unless these tell the suspect to the last digit. Where that
    leaves something, it is as it was found: whatever else is wrong would go into the suspect, and a
    black level that walks would go into the light.

    Processing hides how a demosaicer counts, and shows it once it is itself accounted for, under
    that light.
    """
    found = choice.best
    effects = (*model.effects, found.effect)
    fit_half, _ = halves(setting.seen)
    now, scenery = refined(found.base, fit_half, found.scenery, effects), found.scenery
    lit = as_shown(now, scenery)
    if now.misfit <= FITS_MISFIT and found.model is None and found.told is None:
        fitted = refine(now.base, fit_half, lit, effects, steps=ANEW_STEPS, tuned=found.name)
        calibrated = step_to(setting, choice, around_it(fitted, lit))
        if calibrated.ends and not _is_gone(calibrated):
            return calibrated
    step = step_to(setting, choice, found.model or around_it(now, scenery))
    if step.ends:
        return step
    shown = refined(now.base, fit_half, lit, effects)
    again = recounted(shown, fit_half, lit)
    if again is shown:
        return step
    return nearer(step, step_to(setting, choice, around_it(again, lit)))


def alone(setting: Setting, known: Fit, step: Step) -> Step:
    """The step without the effects that were added before the last one, calibrated anew.

    Args:
        setting: the capture.
        known: the camera before any effect was added.
        step: by which the effect was added to others.
    """
    effects = *known.effects, step.model.effects[-1]
    return _calibrated(setting, step, effects, step.model.base)


def _calibrated(setting: Setting, step: Step, effects: Sequence[Effect], base: Base) -> Step:
    """A step to a camera with these effects, the last of which is calibrated along with it, from a
    camera that is near.
    """
    scenery, name = step.model.scenery, effects[-1].name
    fit_half, _ = halves(setting.seen)
    found = refine(base, fit_half, scenery, effects, steps=ANEW_STEPS, tuned=name)
    return step_to(setting, step.choice, around_it(found, scenery))


def likeliest_step(
    setting: Setting,
    model: Fit,
    now: Measured,
    candidates: Sequence[Candidate],
    choice: Choice,
    watch: Watch,
) -> Step | None:
    """The step that the best suspect makes, or one of its rivals; None where none may be made.

    Args:
        setting: the capture.
        model, now: the camera so far, and the capture against it.
        candidates: the suspects that may be added, best first.
        choice: the best of them.
        watch: told what is being done.
    """
    step = with_it(setting, model, now, choice, watch)
    not_it = _is_no_cause(step, now)
    if step.ends and not not_it:
        return step
    # where the best is wrong beyond doubt, a rival may leave a little
    enough = NEARLY_CLOSED if not_it or step.left.whole.p_value < CERTAIN else SIGNIFICANCE
    beaten = set()
    for other in _rivals(choice.best, candidates):
        # a drawn pattern is wide enough to leave little of whatever is wrong with a picture
        wide = other.name in DRAWN
        if wide and not not_it and nothing_left(now, step.left):
            continue
        instead = with_it(setting, model, now, choice.instead(other, candidates), watch)
        if _is_no_cause(instead, now):
            continue
        if instead.left.whole.p_value >= enough:
            return dataclasses.replace(instead, ends=True)
        if not (not_it or wide) and _far_nearer(instead.left, step.left):
            return instead
        if _far_nearer(step.left, instead.left):
            beaten.add(other.name)
    first = dataclasses.replace(step.choice, beaten=frozenset(beaten))
    return None if not_it else dataclasses.replace(step, choice=first)


def _far_nearer(one: Measured, other: Measured) -> bool:
    """Whether a model leaves hardly anything of what another one leaves, and that is wrong beyond
    doubt in some family and this one in none.
    """
    mine, others = one.whole.p_by_family.values(), other.whole.p_by_family.values()
    most = closed(other.held.total, one.held.total) >= LEAST_SHRINK
    return most and other.held.total > 0 and min(others) < CERTAIN < min(mine)


def _is_no_cause(step: Step, now: Measured) -> bool:
    """Whether a gap is closed by an effect's width alone, or by one of which nothing is left."""
    return closes_by_width(step, now) or _is_gone(step)


def closes_by_width(step: Step, now: Measured) -> bool:
    """Whether a gap is closed by the width that an effect gives to all that is expected.

    Args:
        step: by which the effect was added.
        now: the capture against the model without it.
    """
    return too_wide(step.left) or not accounts(step.choice.best, now, step.left)


def _rivals(best: Candidate, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Suspects besides the best that are worth a second look: by their scores, and the one that
    fits best, if the best does not. What makes whole frames wander fits before its score shows it.
    """
    others = [c for c in candidates if c is not best]
    least = max(LEAST_SCORE, SECOND_LOOK * best.score)
    enough = max(TOO_MUCH_LEFT, FAR_LESS * best.misfit)
    by_score = [
        c for c in others if c.score > least and (c.misfit < enough or c.model is not None)
    ][:MOST_RIVALS]
    fitting = [c for c in others if c.score > LEAST_SCORE and c.misfit <= MISFIT < best.misfit]
    by_fit = sorted(fitting, key=lambda c: c.misfit)[:1]
    return [*by_score, *(c for c in by_fit if c not in by_score)]
