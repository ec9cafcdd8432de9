"""The whole diagnosis: calibrate, measure the gap, ask every suspect, and say what may be said."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.gap.arithmetic import IN_FRACTIONS
from analysis.gap.attribute import attribute, shows
from analysis.gap.base import Base, camera_of
from analysis.gap.calibrate import before, first_guess
from analysis.gap.case import Candidate, Case
from analysis.gap.conclude import TOO_FEW, Trail, conclude, insufficient
from analysis.gap.fit import FITS, Fit, around, counted, misfit, refine
from analysis.gap.hints import Hints, brightest, period_px
from analysis.gap.measured import Measured, measured
from analysis.gap.observe import Observation
from analysis.gap.report import GapReport
from analysis.gap.setting import Setting, halves, look, too_little
from analysis.gap.suspects import Signature, strengths
from analysis.gap.twin import Scenery
from analysis.gap.verdict import (
    EQUIVALENT,
    LEAST_SCORE,
    SIGNIFICANCE,
    Choice,
    both,
    choose,
    p_of_best,
)
from render.rate import RateImage
from sensor.camera import Camera
from sensor.catalogue import catalogue
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.black_level_offset import BlackLevelOffset
from sensor.effects.white_balance import WhiteBalance
from sensor.frames import Capture

Watch = Callable[[str], None]


def calibrated(setting: Setting, nominal: Camera | None) -> Fit:
    """The base camera of a capture, from the frames that fit."""
    fit_half, _ = halves(setting.seen)
    start = first_guess(fit_half, setting.scenery, nominal, setting.black_dn, setting.arithmetic)
    if setting.white_balance is not None:
        start = before(setting.white_balance, start)
    # what is calibrated is so whatever the camera says of it
    own = (BlackLevelOffset, WhiteBalance) if setting.white_balance else (BlackLevelOffset,)
    effects = tuple(
        e
        for e in (nominal.effects if nominal is not None else ())
        if not e.base and not isinstance(e, own)
    )
    base, _ = refine(start, fit_half, setting.scenery, effects)
    if start.dark_e_per_s > 0:
        without = dataclasses.replace(start, dark_e_per_s=0.0)
        base = _better(base, without, fit_half, setting.scenery, effects)
    if setting.arithmetic == IN_FRACTIONS:
        other = counted(base, fit_half, setting.scenery, effects)
        if other is not base:
            base, _ = refine(other, fit_half, setting.scenery, effects)
    return around(base, setting.scenery, effects)


def _better(
    base: Base, start: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect]
) -> Base:
    """The base, or where it does not fit the one that another start leads to, if that is better.

    Below half a code of noise, rounding makes the variance of darks grow and fall with their mean
    just as a dark current would.
    """
    left = misfit(base, seen, scenery, effects)
    if left < FITS:
        return base
    other, _ = refine(start, seen, scenery, effects)
    return other if misfit(other, seen, scenery, effects) < left else base


def hints_of(setting: Setting, case: Case) -> Hints:
    """Where searches for a period and a place should begin."""
    space = case.fitting.turned.space
    count, size = len(space.keys), int(np.prod(space.shape))
    image = case.fit_left[count : count + size].reshape(space.shape)
    across, below = brightest(image, setting.seen.grid)
    stacks = [f for f in setting.capture.frames if f.shot.label in setting.plan.key]
    period = period_px(stacks, setting.scenery.view.lattices)
    return {"across": across, "below": below, "period_px": period, **setting.told}


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """Everything that a diagnosis found, for those who want more than the report.

    Attributes:
        report: what may be said.
        setting: the capture, its plan and its light; None where it has too few frames.
        trail: the base, the effects that were added to it, and the distance from each; the same.
    """

    report: GapReport
    setting: Setting | None = None
    trail: Trail | None = None

    @property
    def camera(self) -> Camera | None:
        """The camera with everything that was found, in the units of its own light."""
        if self.trail is None:
            return None
        last = self.trail.models[-1]
        made = camera_of(last.base, last.scenery.body).plus(*last.effects)
        if not last.base.level or not last.scenery.light.known:
            return made
        level = np.mean(list(last.base.level.values()), axis=0)
        level = np.repeat(level, 3) if len(level) == 1 else level
        sensitivity = Colours(R=float(level[0]), G=float(level[1]), B=float(level[2]))
        return dataclasses.replace(made, sensitivity=sensitivity)


def diagnose(
    capture: Capture,
    model: Camera | None = None,
    *,
    stated: Mapping[str, RateImage] | None = None,
    suspects: Iterable[type[Effect]] | None = None,
    watch: Watch = lambda what: None,
) -> Diagnosis:
    """Where a simulated camera differs from the one that took these frames, and why.

    Args:
        capture: the frames.
        model: a camera to start from; its effects beyond the base count as known.
        stated: rate images by lamp, where they are known.
        suspects: kinds of effect; all of the catalogue by default.
        watch: told what is being done.

    Raises:
        InputError: for a scene that the frames do not show.
    """
    began = time.monotonic()

    def timed(report: GapReport) -> GapReport:
        return dataclasses.replace(report, seconds=time.monotonic() - began)

    trouble = too_little(capture)
    setting = None if trouble else look(capture, stated or {})
    if setting is None:
        return Diagnosis(report=timed(insufficient(trouble or TOO_FEW)))
    watch("calibrating the base camera")
    known = calibrated(setting, model)
    kinds = [k for k in (catalogue().values() if suspects is None else suspects) if not k.base]
    trail = follow(setting, known, kinds, watch)
    return Diagnosis(report=timed(conclude(setting, trail)), setting=setting, trail=trail)


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

    def tell(name: str) -> None:
        watch(f"suspect {name}")

    while True:
        model, now = models[-1], distances[-1]
        left = [k for k in kinds if k not in {type(e) for e in model.effects}]
        hints = hints_of(setting, now.case)
        # what an effect does hardly depends on what else the camera has, but hints do
        again = [k for k in left if not shown or any(p.name in hints for p in k.parameters())]
        shown = [s for s in shown if type(s.effect) in set(left) - set(again)]
        shown += shows(now.case, again, hints, tell)
        told = {k.name for k in left if any(p.name in setting.told for p in strengths(k))}
        candidates = attribute(now.case, shown, tell, told=told)
        first = first or candidates
        chances.append(both(now.whole.p_value, p_of_best(candidates)))
        choice = choose(candidates) if chances[-1] < SIGNIFICANCE else None
        if choice is None or not _accounts(choice.best, now):
            break
        if choices and not _deserves(choice.best, choices[0].best):
            break
        watch(f"confirming {choice.best.name}")
        added, further = _with_it(setting, model, choice.best)
        if choices and further.held.total > CLOSES_LITTLE * now.held.total:
            break
        if further.held.total < TOO_WIDE:
            break
        fits = further.whole.p_value >= SIGNIFICANCE
        named = choose(candidates, fits) or choice
        if not choices and not fits:
            for other in _rivals(candidates):
                watch(f"confirming {other.name} instead")
                instead, left_by_it = _with_it(setting, model, other)
                closes = left_by_it.whole.p_value >= SIGNIFICANCE
                if closes and left_by_it.held.total > TOO_WIDE and _accounts(other, now):
                    added, further, fits = instead, left_by_it, True
                    named = named.instead(other)
                    break
        models.append(added)
        distances.append(further)
        choices.append(named)
        closed = further.held.total < LITTLE * distances[0].held.total
        if fits or closed or len(choices) == MOST_EFFECTS:
            chances.append(further.whole.p_value)
            break
    return Trail(
        models=tuple(models),
        measured=tuple(distances),
        choices=tuple(choices),
        candidates=tuple(first),
        p_before=chances[0],
        p_after=chances[-1],
    )


def _with_it(setting: Setting, model: Fit, found: Candidate) -> tuple[Fit, Measured]:
    """The model with a suspect added, and what it leaves of the capture."""
    added = around(found.base, setting.scenery, (*model.effects, found.effect))
    return added, measured(added, setting.seen)


TOO_WIDE = -0.3
"""G below which a model expects far more than these frames show: one body of it would not be so
like another one as this capture is like its own picture. Right models have 0 within 0.1."""

SECOND_LOOK = 0.2
"""Part of the best score from which another suspect is tried where the best leaves something: one
effect that closes the gap alone is likelier than two that do it together."""

MOST_RIVALS = 2


def _rivals(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Suspects behind the best that are worth a second look."""
    least = max(LEAST_SCORE, SECOND_LOOK * candidates[0].score)
    return [c for c in candidates[1:] if c.score > least][:MOST_RIVALS]


LARGE = 0.3
"""A gap from which the part of it that a suspect takes off means something."""

LEAST_PART = 0.12
"""Part of a large gap that the signature of a suspect takes off. A pattern that is another one in
every body makes every expectation wide, and would close any gap of the picture by that alone."""


def _accounts(best: Candidate, now: Measured) -> bool:
    """Whether it is the suspect's own signature that closes the gap."""
    gap = now.held.total
    taken = best.forward / float(now.rod.spread.expected.sum())
    return gap < LARGE or taken > LEAST_PART * gap


def _deserves(later: Candidate, first: Candidate) -> bool:
    """Whether an effect is to be added to another one."""
    least = max(LEAST_OF_A_LATER, PART_OF_THE_FIRST * first.score)
    return later.score > least and later.absorbed < EQUIVALENT
