"""Add effects to the base camera, as long as something is left and one may be named."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured, measured
from analysis.gap.measure.signature import Signature
from analysis.gap.ready.setting import Setting
from analysis.gap.search.choice import (
    LEAST_SHRINK,
    MOST_CAUSES,
    SIGNIFICANCE,
    TELLS_LITTLE,
    WEAK,
    Choice,
    choose,
)
from analysis.gap.search.closing import closed, nothing_left
from analysis.gap.search.confirm import alone, likeliest_step
from analysis.gap.search.last_steps import at_its_end
from analysis.gap.search.later import (
    LEAST_OF_A_LATER,
    deserves,
    earned,
    instead_of_it,
    leads,
    no_worse,
)
from analysis.gap.search.remainder import score_apart
from analysis.gap.search.step import Step, Watch
from analysis.gap.search.suspected import Heard, Look, looked
from analysis.gap.search.trail import Trail
from analysis.gap.suspects.attribute import at_first_sight
from analysis.gap.suspects.direct_readings import hints_of_frames, told_by
from analysis.gap.suspects.first_look import closer
from sensor.effect import Effect

MOST_EFFECTS = MOST_CAUSES + 1
"""That are looked for: one more than may be named says that it is none of them."""

ASTRAY_MISFIT = 4.0
"""Misfit from which a camera is not one that was taken from the frames: it was calibrated to what
an effect does as well as it could be, and what others do beside it they do beside no camera. One
that had lost bits had a dark current of its noise, and no smear showed beside that."""

MORE_TWINS = 72
"""Bodies that are simulated before the base camera is called another one for what is hardly there.

Of two dozen the spread of what their patterns do to the picture may be two thirds of what it is: in
a raw camera by another engineer, in which nothing was wrong, the two greens differed by colour by
2.3 to 2.9 times the spread of a hundred bodies, and by 3.8 to 4.5 times that of 24; as they did so
in all shots, that was a deferred charge with a score of 57."""

DIFFER = 0.3
"""Standard error of G from which no suspect stands out of a model that fits: its bodies differ by a
few photosites, of which two dozen twins do not tell where else they may be. A leak at the largest
code is a spot of light to whoever looks at means of blocks."""


def follow(setting: Setting, known: Fit, kinds: Sequence[type[Effect]], watch: Watch) -> Trail:
    """Add the effect that explains most, as long as something is left and one may be named.

    Args:
        setting: the capture.
        known: the calibrated base.
        kinds: the suspects.
        watch: told what is being done.
    """
    base = measured(known, setting.seen)
    told = told_by(setting, known.base)
    heard = Heard(told=told, hints=hints_of_frames(setting, known.base, told))
    search = _Search(setting=setting, known=known, base=base, kinds=kinds, heard=heard, watch=watch)
    steps: tuple[Step, ...] = ()
    lead: Step | None = None
    look = search.beside(known, base)
    if _may_be_its_bodies(look, base):
        watch("simulating more bodies")
        known = around(known.base, known.scenery, known.effects, count=MORE_TWINS)
        base = measured(known, setting.seen)
        search = dataclasses.replace(search, known=known, base=base)
        look = search.beside(known, base, look.shown)
    first = look
    while True:
        further = _further(search, steps, look)
        if further is None:
            p_after = look.chance
            break
        steps, last = further, further[-1]
        lead = lead or last
        if len(steps) == MOST_EFFECTS or _in_vain(steps, base) or _done(steps, base, look.shown):
            p_after = last.left.whole.p_value
            break
        before = steps[-2].left if len(steps) > 1 else base
        near = before.case.misfit < ASTRAY_MISFIT
        look = search.beside(last.model, last.left, look.shown if near else ())
    if 0 < len(steps) <= MOST_CAUSES and not _in_vain(steps, base):
        watch("confirming how strong it is")
        fitted = {one.name for one in (step.choice.best for step in steps) if one.told is None}
        last = at_its_end(setting, steps[-1], fitted)
        # a suspect that stands out beside the model as it was may still do so
        of_it = p_after == steps[-1].left.whole.p_value
        p_after = last.left.whole.p_value if of_it else min(p_after, last.left.whole.p_value)
        steps = (*steps[:-1], last)
    of_lead = None if lead is None else _trail(search, first, (lead,), lead.left.whole.p_value)
    return dataclasses.replace(_trail(search, first, steps, p_after), lead=of_lead)


def _trail(search: _Search, first: Look, steps: tuple[Step, ...], p_after: float) -> Trail:
    """What so many steps have led to.

    Args:
        search: what stays the same.
        first: look at all suspects.
        steps: the effects that were added.
        p_after: chance of what they leave.
    """
    return Trail(
        models=(search.known, *(step.model for step in steps)),
        measured=(search.base, *(step.left for step in steps)),
        choices=tuple(step.choice for step in steps),
        candidates=first.candidates,
        p_before=first.chance,
        p_after=p_after,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """What stays the same from one effect to the next.

    Attributes:
        setting: the capture.
        known, base: the camera without any effect, and the capture against it.
        kinds: the suspects.
        heard: what the frames tell of them.
        watch: told what is being done.
    """

    setting: Setting
    known: Fit
    base: Measured
    kinds: Sequence[type[Effect]]
    heard: Heard
    watch: Watch

    def beside(
        self,
        model: Fit,
        left: Measured,
        shown: Sequence[Signature] = (),
        kinds: Sequence[type[Effect]] = (),
    ) -> Look:
        """The suspects of what a model leaves, or those of these kinds; `shown` as they did beside
        one near it.
        """
        return looked(model, left, kinds or self.kinds, shown, self.heard, self.watch)

    def step(
        self, model: Fit, left: Measured, candidates: Sequence[Candidate], choice: Choice
    ) -> Step | None:
        """The step that the best of these suspects makes from a model, or one of its rivals."""
        return likeliest_step(self.setting, model, left, candidates, choice, self.watch)


def _may_be_its_bodies(look: Look, base: Measured) -> bool:
    """Whether what little speaks against the base camera may be how few of its bodies were looked
    at: their patterns are the same in every shot, so that a spread which came out too small does so
    for all of them at once.

    Args:
        look: at all suspects.
        base: the capture against the base camera.
    """
    best = max((one.score for one in look.telling), default=0.0)
    return look.chance < SIGNIFICANCE and base.held.total < TELLS_LITTLE and best < WEAK[1]


def _further(search: _Search, steps: tuple[Step, ...], look: Look) -> tuple[Step, ...] | None:
    """The steps with one more, or that one alone where it does as well, or that one and what is
    likelier beside it; None where none may be named.

    Args:
        search: what stays the same.
        steps: so far.
        look: at the suspects of what they leave.
    """
    base = search.base
    choice = choose(look.telling) if look.chance < SIGNIFICANCE else None
    if choice is None:
        return None
    if not steps:
        step = search.step(search.known, base, look.telling, choice)
        return (step,) if step is not None and leads(step, base) else None
    first, now = steps[0].choice.best, steps[-1].left
    worthy = [
        one
        for one in look.telling
        if deserves(one, first, base, now, score_apart(one.name, look.shown, base.case, now.case))
    ]
    if choice.best not in worthy:
        return None
    step = search.step(steps[-1].model, now, worthy, choice)
    if step is None or not earned(step, base, now, first):
        return None
    search.watch(f"confirming {step.choice.best.name} alone")
    by_itself = alone(search.setting, search.known, step)
    if no_worse(by_itself.left, step.left):
        return (by_itself,)
    both = (*steps, step)
    if len(both) == MOST_CAUSES and not _in_vain(both, base):
        again = _chosen_again(search, steps[0], step, by_itself)
        if again is not None:
            return (by_itself, again)
    return None if instead_of_it(step.choice.best, base, by_itself.left) else both


def _chosen_again(search: _Search, first: Step, second: Step, by_itself: Step) -> Step | None:
    """What is likelier beside the second effect than the first one, if both leave no more, or no
    more than chance where the first and the second do; the first one itself, from where it began,
    where it fits only so.

    The first was chosen for what two effects do; of what one of them leaves, another suspect may
    explain more. And its strength was fitted to what both do: beside columns a smoothing of 0.30
    ended at 0.01, from where no step led back.

    Args:
        search: what stays the same.
        first, second: by which the effects were added, one after the other.
        by_itself: the second without the first.
    """
    kind = type(first.choice.best.effect)
    needed = by_itself.left.held.total > search.base.held.total
    if needed and second.ends:
        return None
    # whoever comes beside what makes things worse has to do what the first one does
    kinds = (kind,) if needed else search.kinds
    look = search.beside(by_itself.model, by_itself.left, kinds=kinds)
    choice = choose(look.telling) if look.chance < SIGNIFICANCE else None
    if choice is None or (second.ends and not _displaced(kind.name, look.telling)):
        return None
    if needed:
        choice = dataclasses.replace(first.choice, best=choice.best)
    step = search.step(by_itself.model, by_itself.left, look.telling, choice)
    if step is None:
        return None
    likelier = step.ends and not second.ends
    if type(step.choice.best.effect) is kind:
        return step if likelier else None
    return step if likelier or no_worse(step.left, second.left) else None


def _displaced(first: str, candidates: Sequence[Candidate]) -> bool:
    """Whether the best suspect beside a second effect fits better than the first effect, with which
    nothing is left: scores tell little of two that fit. Beside a converter's steps a veil scored
    197 and a gamma 160, which left less.

    Args:
        first: name of the effect.
        candidates: beside the second one, best first.
    """
    best = candidates[0]
    return all(best.misfit < one.misfit for one in candidates if one.name == first)


def _in_vain(steps: Sequence[Step], base: Measured) -> bool:
    """Whether as many effects as may be named leave so much that the gap has no name, and would
    have none with a third, unless that did by itself what all three do.
    """
    left = steps[-1].left
    part = closed(base.held.total, left.held.total, base.floor)
    return len(steps) == MOST_CAUSES and left.case.misfit >= ASTRAY_MISFIT and part < LEAST_SHRINK


def _done(steps: Sequence[Step], base: Measured, shown: Sequence[Signature]) -> bool:
    """Whether nothing more is looked for: nothing is left to explain, and no suspect stands out all
    the same, or can.
    """
    first, last = steps[0], steps[-1]
    if last.ends and last.left.held_error > DIFFER:
        return True
    done = last.ends or nothing_left(base, last.left)
    return done and not _another(last, shown, first.choice.best, base)


def _another(step: Step, shown: Sequence[Signature], first: Candidate, base: Measured) -> bool:
    """Whether a suspect stands out where the whole is no more than chance makes.

    A second effect may be lost among thousands of figures that are as they should be, and not along
    its own direction; see `later.LEAST_WHERE_LITTLE`.
    """
    known = {type(effect) for effect in step.model.effects}
    left = [one for one in shown if type(one.effect) not in known]
    case = step.left.case
    near = closer(case, left, least=LEAST_OF_A_LATER)
    best = at_first_sight(case, near)
    if best is None:
        return False
    return deserves(best, first, base, step.left, score_apart(best.name, near, base.case, case))
