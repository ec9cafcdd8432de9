"""Add effects to the base camera, as long as something is left and one may be named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from analysis.gap.calibrate.fit import Fit
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured, measured
from analysis.gap.measure.signature import Signature
from analysis.gap.ready.hints import Hints, Told
from analysis.gap.ready.setting import Setting
from analysis.gap.suspects.attribute import at_first_sight, attribute
from analysis.gap.suspects.first_look import closer, shows, weaker
from analysis.gap.suspects.told import hints_of, hints_of_frames, told_by
from analysis.gap.verdict.closing import nothing_left
from analysis.gap.verdict.confirm import Step, Watch, alone, likeliest_step
from analysis.gap.verdict.later import LEAST_OF_A_LATER, deserves, earned, instead_of_it, no_worse
from analysis.gap.verdict.trail import Trail
from analysis.gap.verdict.verdict import SIGNIFICANCE, both, choose, p_of_best, telling
from sensor.effect import Effect

MOST_EFFECTS = 3

ASTRAY = 4.0
"""Misfit from which a camera is not one that was taken from the frames: it was calibrated to what
an effect does as well as it could be, and what others do beside it they do beside no camera. One
that had lost bits had a dark current of its noise, and no smear showed beside that."""


def follow(setting: Setting, known: Fit, kinds: Sequence[type[Effect]], watch: Watch) -> Trail:
    """Add the effect that explains most, as long as something is left and one may be named.

    Args:
        setting: the capture.
        known: the calibrated base.
        kinds: the suspects.
        watch: told what is being done.
    """
    base = measured(known, setting.seen)
    heard = _Heard(told=told_by(setting, known.base), hints=hints_of_frames(setting, known.base))
    steps: tuple[Step, ...] = ()
    first = look = _looked(known, base, kinds, (), heard, watch)
    while True:
        further = _further(setting, known, base, steps, look, watch)
        if further is None:
            p_after = look.chance
            break
        steps, last = further, further[-1]
        if len(steps) == MOST_EFFECTS or _done(steps, base, look.shown):
            p_after = last.left.whole.p_value
            break
        before = steps[-2].left if len(steps) > 1 else base
        near = before.case.misfit < ASTRAY
        look = _looked(last.model, last.left, kinds, look.shown if near else (), heard, watch)
    return Trail(
        models=(known, *(step.model for step in steps)),
        measured=(base, *(step.left for step in steps)),
        choices=tuple(step.choice for step in steps),
        candidates=first.candidates,
        p_before=first.chance,
        p_after=p_after,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Heard:
    """What the frames tell: of which suspects, and where the search for others begins."""

    told: Mapping[str, Told]
    hints: Mapping[str, Hints]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Look:
    """The suspects of what a model leaves.

    Attributes:
        shown: how they show, at this model or at one near it.
        candidates: best first.
        telling: those that may be evidence, best first.
        chance: of what is left, as a whole and along the best of these.
    """

    shown: tuple[Signature, ...]
    candidates: tuple[Candidate, ...]
    telling: tuple[Candidate, ...]
    chance: float


def _looked(
    model: Fit,
    now: Measured,
    kinds: Sequence[type[Effect]],
    shown: Sequence[Signature],
    heard: _Heard,
    watch: Watch,
) -> _Look:
    """Every suspect that is not in the model, held against what it leaves; `shown` is how they
    showed before, beside a model near this one.
    """

    def tell(name: str) -> None:
        watch(f"suspect {name}")

    left = [k for k in kinds if k not in {type(e) for e in model.effects}]
    hints = hints_of(now.case)
    # what an effect does hardly depends on what else the camera has, but hints do
    again = [k for k in left if not shown or k.name in hints]
    kept = [s for s in shown if type(s.effect) in set(left) - set(again)]
    seen = [*kept, *shows(now.case, again, {**heard.hints, **hints}, heard.told, tell)]
    seen = closer(now.case, [*seen, *weaker(now.case, seen, tell)], tell)
    candidates = attribute(now.case, seen, tell, told=heard.told)
    evidence = telling(candidates, now.whole.p_value)
    by_best = p_of_best(evidence)
    return _Look(
        shown=tuple(seen),
        candidates=tuple(candidates),
        telling=tuple(evidence),
        chance=both(now.whole.p_value, by_best),
    )


def _further(
    setting: Setting,
    known: Fit,
    base: Measured,
    steps: tuple[Step, ...],
    look: _Look,
    watch: Watch,
) -> tuple[Step, ...] | None:
    """The steps with one more, or that one alone where it does as well; None where none may be
    named.
    """
    choice = choose(look.telling) if look.chance < SIGNIFICANCE else None
    if choice is None:
        return None
    if not steps:
        step = likeliest_step(setting, known, base, look.telling, choice, watch)
        return None if step is None else (step,)
    first, now = steps[0].choice.best, steps[-1].left
    worthy = [one for one in look.telling if deserves(one, first, base, now)]
    if choice.best not in worthy:
        return None
    step = likeliest_step(setting, steps[-1].model, now, worthy, choice, watch)
    if step is None or not earned(step, base, now, first):
        return None
    watch(f"confirming {step.choice.best.name} alone")
    by_itself = alone(setting, known, step)
    if no_worse(by_itself.left, step.left):
        return (by_itself,)
    return None if instead_of_it(step.choice.best, base, by_itself.left) else (*steps, step)


def _done(steps: Sequence[Step], base: Measured, shown: Sequence[Signature]) -> bool:
    """Whether nothing more is looked for: nothing is left to explain, and no suspect stands out all
    the same.
    """
    first, last = steps[0], steps[-1]
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
    best = at_first_sight(case, closer(case, left, least=LEAST_OF_A_LATER))
    return best is not None and deserves(best, first, base, step.left)
