"""The model with a suspect added, and whether that is its own doing."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.calibrate.refine import Refined, as_shown, refine, refined, stepped
from analysis.gap.camera.handles import does_nothing
from analysis.gap.camera.twin import Scenery
from analysis.gap.measure.case import MISFIT, Candidate
from analysis.gap.measure.measured import Measured, measured
from analysis.gap.ready.setting import Setting, halves
from analysis.gap.suspects.anew import ANEW_STEPS, anew
from analysis.gap.suspects.recount import recounted
from analysis.gap.verdict.closing import CERTAIN, TELLS_LITTLE, TOO_WIDE, accounts, closed
from analysis.gap.verdict.verdict import LEAST_SCORE, LEAST_SHRINK, SIGNIFICANCE, Choice
from sensor.effect import Effect

Watch = Callable[[str], None]

SECOND_LOOK = 0.2
"""Part of the best score from which another suspect is tried where the best leaves something: one
effect that closes the gap alone is likelier than two that do it together."""

MOST_RIVALS = 2

TOO_MUCH_LEFT = 2.0
"""Misfit from which a rival is not tried, unless it makes bodies differ: it would leave far more
than chance."""

NEARLY_CLOSED = 1e-3
"""What a rival may leave where the best leaves something beyond doubt."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """An effect that was added: what is said of it, the model with it, and what that leaves;
    `ends` where nothing more is to be added.
    """

    choice: Choice
    model: Fit
    left: Measured
    ends: bool


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
            step = _nearer(step, _as_found(setting, model, choice))
    most = closed(now.held.total, step.left.held.total) >= LEAST_SHRINK
    if step.ends or not most:
        return step
    if _was_calibrated(choice.best):
        return _nearer(step, _further(setting, step))
    return _nearer(step, _calibrated(setting, step, step.model.effects))


def _was_calibrated(found: Candidate) -> bool:
    """Whether the camera of a suspect is that of steps by twins: not where the frames tell it, or
    where all that is around it was asked for at once.
    """
    return found.model is None and found.told is None


def _as_found(setting: Setting, model: Fit, choice: Choice) -> Step:
    """The step with the camera that the search for the suspect leads to.

    A search ends where scores tell suspects apart. Its amounts are least squares along directions
    that were read beside the camera without it, under light as the frames show it to that one, and
    the camera may still be far from its end: a gamma came out with two thirds of its bend, and a
    gain that was 4 % too low. So the camera is calibrated with the suspect, under light as the
    frames show it to both, unless the frames tell the suspect to the last digit.

    Processing hides how a demosaicer counts, and shows it once it is itself accounted for.
    """
    found = choice.best
    effects = (*model.effects, found.effect)
    fit_half, _ = halves(setting.seen)
    now, scenery = refined(found.base, fit_half, found.scenery, effects), found.scenery
    if _was_calibrated(found):
        scenery = as_shown(now, scenery)
        now = refine(now.base, fit_half, scenery, effects, steps=ANEW_STEPS, tuned=found.name)
    step = _step(setting, choice, found.model or _around(now, scenery))
    if step.ends:
        return step
    again = recounted(now, fit_half, scenery)
    if again is now:
        return step
    return _nearer(step, _step(setting, choice, _around(again, scenery)))


def _nearer(one: Step, other: Step) -> Step:
    """The one that leaves less; where both leave little, whose worst family is likelier."""
    first, second = one.left, other.left
    if max(first.held.total, second.held.total) < TELLS_LITTLE:
        closer = min(second.whole.p_by_family.values()) > min(first.whole.p_by_family.values())
    else:
        closer = second.held.total < first.held.total
    return other if closer else one


LONG = 0.5
"""Standard errors of a parameter beyond which the last step of a fit is not its last."""

LAST_STEPS = 2
"""At most."""


def at_its_end(setting: Setting, step: Step) -> Step:
    """The same with a camera from which no step leads further, if the last one was long.

    Args:
        setting: the capture.
        step: by which the last effect was added.
    """
    for _ in range(LAST_STEPS):
        if not _is_long(step):
            break
        further = _further(setting, step)
        if further.left.whole.total > step.left.whole.total + step.left.held_error:
            break
        step = further
    return step


def _further(setting: Setting, step: Step) -> Step:
    """The same a step further, by all that is known around the camera.

    Steps of a calibration are made by a few twins and the frames that fit, and whatever these are
    off by chance goes into the camera. Around it there are many twins, all key frames, and the
    directions of this very place: of a gamma that was 3 standard errors off the first such step
    leaves 1.
    """
    model, left = step.model, step.left
    fit_half, _ = halves(setting.seen)
    now = refined(model.base, fit_half, model.scenery, model.effects)
    tuned = {handle.effect for handle in model.ways.tuned}
    found = stepped(now, model.ways, left.amounts, fit_half, model.scenery, tuned=tuned)
    return _step(setting, step.choice, _around(found, model.scenery))


def _is_long(step: Step) -> bool:
    """Whether a parameter that was fitted would move by a good part of what it is known to."""
    knobs, found = len(step.model.ways.knobs), step.choice.best
    fitted = zip(
        step.model.ways.tuned, step.left.amounts[knobs:], step.left.errors[knobs:], strict=False
    )
    return any(
        abs(amount) > LONG * error
        for handle, amount, error in fitted
        if found.told is None or handle.effect != found.name
    )


def alone(setting: Setting, known: Fit, step: Step) -> Step:
    """The same without the effects that were added before the last one, calibrated anew.

    Args:
        setting: the capture.
        known: the camera before any effect was added.
        step: by which the effect was added to others.
    """
    return _calibrated(setting, step, (*known.effects, step.model.effects[-1]))


def _calibrated(setting: Setting, step: Step, effects: Sequence[Effect]) -> Step:
    """The same with these effects, the last of which is calibrated along with the camera."""
    scenery, name = step.model.scenery, effects[-1].name
    fit_half, _ = halves(setting.seen)
    found = refine(step.model.base, fit_half, scenery, effects, steps=ANEW_STEPS, tuned=name)
    return _step(setting, step.choice, _around(found, scenery))


def _around(found: Refined, scenery: Scenery) -> Fit:
    """Everything around a model, under light as the frames show it to a camera like that."""
    return around(found.base, as_shown(found, scenery), found.effects)


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
    for other in _rivals(candidates):
        instead = with_it(setting, model, now, choice.instead(other), watch)
        if _is_no_cause(instead, now):
            continue
        if instead.left.whole.p_value >= enough:
            return dataclasses.replace(instead, ends=True)
        if not not_it and _far_nearer(instead.left, step.left):
            return instead
    return None if not_it else step


def _far_nearer(other: Measured, best: Measured) -> bool:
    """Whether a model leaves hardly anything of what the best leaves, and that is wrong beyond
    doubt in some family and this one in none.
    """
    first, second = best.whole.p_by_family.values(), other.whole.p_by_family.values()
    most = closed(best.held.total, other.held.total) >= LEAST_SHRINK
    return most and best.held.total > 0 and min(first) < CERTAIN < min(second)


def _is_no_cause(step: Step, now: Measured) -> bool:
    """Whether a gap is closed by an effect's width alone, or by one that does next to nothing once
    the camera is calibrated with it.
    """
    return closes_by_width(step, now) or does_nothing(step.model.effects[-1])


def closes_by_width(step: Step, now: Measured) -> bool:
    """Whether a gap is closed by the width that an effect gives to all that is expected.

    Args:
        step: by which the effect was added.
        now: the capture against the model without it.
    """
    return step.left.held.total < TOO_WIDE or not accounts(step.choice.best, now, step.left)


def _step(setting: Setting, choice: Choice, model: Fit) -> Step:
    left = measured(model, setting.seen)
    return Step(choice=choice, model=model, left=left, ends=left.whole.p_value >= SIGNIFICANCE)


def _rivals(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Suspects behind the best that are worth a second look: by their scores, and the one that fits
    best, if the best does not. What makes whole frames wander fits before its score shows it.
    """
    best, *others = candidates
    least = max(LEAST_SCORE, SECOND_LOOK * best.score)
    by_score = [
        c for c in others if c.score > least and (c.misfit < TOO_MUCH_LEFT or c.model is not None)
    ][:MOST_RIVALS]
    fitting = [c for c in others if c.score > LEAST_SCORE and c.misfit <= MISFIT < best.misfit]
    by_fit = sorted(fitting, key=lambda c: c.misfit)[:1]
    return [*by_score, *(c for c in by_fit if c not in by_score)]
