"""Add effects to the base camera, as long as something is left and one may be named."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.calibrate.refine import counted, refine, refined
from analysis.gap.measure.case import Candidate, freedom_of
from analysis.gap.measure.measured import Measured, measured
from analysis.gap.measure.signature import Signature
from analysis.gap.ready.setting import Setting, halves
from analysis.gap.suspects.anew import ANEW_STEPS
from analysis.gap.suspects.attribute import at_first_sight, attribute
from analysis.gap.suspects.first_look import closer, shows
from analysis.gap.suspects.told import hints_of, hints_of_frames, told_by
from analysis.gap.verdict.closing import CERTAIN, TOO_WIDE, accounts, closed, untouched
from analysis.gap.verdict.conclude import TELLS_LITTLE, Trail
from analysis.gap.verdict.verdict import (
    EQUIVALENT,
    LEAST_SCORE,
    LEAST_SHRINK,
    SIGNIFICANCE,
    WEAK,
    Choice,
    both,
    choose,
    p_of_best,
)
from sensor.effect import Effect

Watch = Callable[[str], None]


MOST_EFFECTS = 3

LEAST_OF_A_LATER = 25.0
"""Score of an effect that is added to another one: what is left of a gap is easily blamed."""

PART_OF_THE_FIRST = 0.02
"""The same, as a part of the first one's score: a model that is right to a tenth leaves a hundredth
of chi-squared to whoever comes next."""

CLOSES_LITTLE = 0.9
"""Part of the gap that a later effect must not leave."""

LITTLE = 0.05
"""Part of the gap that is left to chance and to the model's own errors: no one else is blamed."""


def follow(setting: Setting, known: Fit, kinds: Sequence[type[Effect]], watch: Watch) -> Trail:
    """Add the effect that explains most, as long as something is left and one may be named.

    Args:
        setting: the capture.
        known: the calibrated base.
        kinds: the suspects.
        watch: told what is being done.
    """
    models, distances = [known], [measured(known, setting.seen)]
    choices: list[Choice] = []
    first: list[Candidate] = []
    chances: list[float] = []
    shown: list[Signature] = []
    told, of_frames = told_by(setting), hints_of_frames(setting, known.base)

    def tell(name: str) -> None:
        watch(f"suspect {name}")

    while True:
        model, now = models[-1], distances[-1]
        left = [k for k in kinds if k not in {type(e) for e in model.effects}]
        hints = hints_of(now.case)
        # what an effect does hardly depends on what else the camera has, but hints do
        again = [k for k in left if not shown or k.name in hints]
        shown = [s for s in shown if type(s.effect) in set(left) - set(again)]
        shown += shows(now.case, again, {**of_frames, **hints}, told, tell)
        shown = closer(now.case, shown, tell)
        candidates = attribute(now.case, shown, tell, told=told)
        first = first or candidates
        by_best = p_of_best(candidates, freedom_of(now.rod.spread))
        chances.append(both(now.whole.p_value, by_best))
        choice = choose(candidates) if chances[-1] < SIGNIFICANCE else None
        if choice is None:
            break
        if choices and not _deserves(choice.best, choices[0].best, now):
            break
        step = _confirmed(setting, model, now, candidates, choice, later=bool(choices), watch=watch)
        if step is None:
            break
        if choices and not _earned(step, now, choices[0].best):
            break
        if choices:
            watch(f"confirming {step.choice.best.name} alone")
            alone = _alone(setting, step)
            if _no_worse(alone.left, step.left):
                step = alone
                del models[1:], distances[1:], choices[:]
        models.append(step.model)
        distances.append(step.left)
        choices.append(step.choice)
        little = step.left.held.total < LITTLE * distances[0].held.total
        everywhere = little and not untouched(distances[0], step.left)
        done = step.ends or everywhere
        if (done and not _another(step, shown, choices[0].best)) or len(choices) == MOST_EFFECTS:
            chances.append(step.left.whole.p_value)
            break
    return Trail(
        models=tuple(models),
        measured=tuple(distances),
        choices=tuple(choices),
        candidates=tuple(first),
        p_before=chances[0],
        p_after=chances[-1],
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Step:
    """An effect that was added: what is said of it, the model with it, and what that leaves;
    `ends` where nothing more is to be added.
    """

    choice: Choice
    model: Fit
    left: Measured
    ends: bool


def _confirmed(
    setting: Setting,
    model: Fit,
    now: Measured,
    candidates: Sequence[Candidate],
    choice: Choice,
    *,
    later: bool,
    watch: Watch,
) -> _Step | None:
    """The step that the best suspect makes, or one of its rivals; None where none may be made."""
    best = choice.best
    watch(f"confirming {best.name}")
    added, left = _with_it(setting, model, best)
    by_width = left.held.total < TOO_WIDE or not accounts(best, now, left)
    little = now.held.total > TELLS_LITTLE and left.held.total > CLOSES_LITTLE * now.held.total
    if later and (by_width or little):
        return None
    fits = left.whole.p_value >= SIGNIFICANCE
    step = _Step(choice=choice, model=added, left=left, ends=fits)
    if later or (fits and not by_width):
        return step
    # where the best is wrong beyond doubt, a rival may leave a little
    enough = NEARLY_CLOSED if by_width or left.whole.p_value < CERTAIN else SIGNIFICANCE
    for other in _rivals(candidates):
        watch(f"confirming {other.name} instead")
        instead, left_by_it = _with_it(setting, model, other)
        closes = left_by_it.whole.p_value >= enough and left_by_it.held.total > TOO_WIDE
        if closes and accounts(other, now, left_by_it):
            return _Step(choice=choice.instead(other), model=instead, left=left_by_it, ends=True)
    return None if by_width else step


def _with_it(setting: Setting, model: Fit, found: Candidate) -> tuple[Fit, Measured]:
    """The model with a suspect added, and what it leaves of the capture.

    Processing hides how a demosaicer counts, and shows it once it is itself accounted for.
    """
    effects = (*model.effects, found.effect)
    added = found.model or around(found.base, setting.scenery, effects)
    left = measured(added, setting.seen)
    if left.whole.p_value >= SIGNIFICANCE:
        return added, left
    fit_half, _ = halves(setting.seen)
    now = refined(found.base, fit_half, setting.scenery, effects)
    base = counted(now, fit_half, setting.scenery, enough=0.0)
    if base is now.base:
        return added, left
    again = refine(base, fit_half, setting.scenery, effects, steps=ANEW_STEPS, tuned=found.name)
    recounted = around(again.base, setting.scenery, again.effects)
    left_so = measured(recounted, setting.seen)
    better = left_so.held.total < left.held.total
    return (recounted, left_so) if better else (added, left)


def _alone(setting: Setting, step: _Step) -> _Step:
    """The same with the last of its effects alone, calibrated anew."""
    last = step.model.effects[-1]
    fit_half, _ = halves(setting.seen)
    found = refine(
        step.model.base, fit_half, setting.scenery, (last,), steps=ANEW_STEPS, tuned=last.name
    )
    model = around(found.base, setting.scenery, found.effects)
    left = measured(model, setting.seen)
    fits = left.whole.p_value >= SIGNIFICANCE
    return _Step(choice=step.choice, model=model, left=left, ends=fits)


def _no_worse(alone: Measured, both_of_them: Measured) -> bool:
    """Whether a later effect by itself leaves hardly more than it does with those before it."""
    more = alone.held.total - both_of_them.held.total
    return more * float(alone.rod.spread.expected.sum()) < LEAST_OF_A_LATER


def _another(step: _Step, shown: Sequence[Signature], first: Candidate) -> bool:
    """Whether a suspect stands out where the whole is no more than chance makes.

    A second effect may be lost among thousands of figures that are as they should be, and not along
    its own direction. After the one effect of ten captures no other suspect had a score above 9;
    after the first of two strong ones, in three more, the other one had 106 to 279.
    """
    known = {type(effect) for effect in step.model.effects}
    left = [one for one in shown if type(one.effect) not in known]
    case = step.left.case
    best = at_first_sight(case, closer(case, left, least=LEAST_OF_A_LATER))
    return best is not None and _deserves(best, first, step.left)


SECOND_LOOK = 0.2
"""Part of the best score from which another suspect is tried where the best leaves something: one
effect that closes the gap alone is likelier than two that do it together."""

MOST_RIVALS = 2

NEARLY_CLOSED = 1e-3
"""What a rival may leave where the best leaves something beyond doubt."""


def _rivals(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Suspects behind the best that are worth a second look."""
    least = max(LEAST_SCORE, SECOND_LOOK * candidates[0].score)
    return [c for c in candidates[1:] if c.score > least][:MOST_RIVALS]


LITTLE_IS_LEFT = 0.25
"""G that one effect may close which is much less than the first."""


def _deserves(later: Candidate, first: Candidate, now: Measured) -> bool:
    """Whether an effect is to be tried beside another one.

    One that is much less than the first is tried where little is left, and has to close most of it.

    Args:
        later, first: the effects.
        now: the capture against the model with the first.
    """
    little = now.whole.p_value < SIGNIFICANCE and now.held.total < LITTLE_IS_LEFT
    tried = (little and later.score > WEAK) or _stands_beside(later, first)
    return tried and later.absorbed < EQUIVALENT


def _earned(step: _Step, now: Measured, first: Candidate) -> bool:
    """Whether a later effect keeps its place: a large one in any case, another if it closes most of
    what the first one leaves.
    """
    most = closed(now.held.total, step.left.held.total) >= LEAST_SHRINK
    return step.ends or most or _stands_beside(step.choice.best, first)


def _stands_beside(later: Candidate, first: Candidate) -> bool:
    """Whether an effect is more than what an error of another one's model leaves."""
    return later.score > max(LEAST_OF_A_LATER, PART_OF_THE_FIRST * first.score)
