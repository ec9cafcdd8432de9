"""Steps of a calibration by all that is known around a camera, once it has been measured."""

from __future__ import annotations

from collections.abc import Collection

from analysis.gap.calibrate.refine import refined, stepped
from analysis.gap.ready.setting import Setting, halves
from analysis.gap.search.step import Step, around_it, step_to

LONG = 0.5
"""Standard errors of a parameter beyond which the last step of a fit is not its last."""

LAST_STEPS = 2
"""At most."""


def at_its_end(setting: Setting, step: Step, tuned: Collection[str]) -> Step:
    """The step to a camera from which no step leads further, if the last one was long.

    Where a model leaves something, steps follow what is left, wherever that leads. One that leaves
    something where nothing was left is not made.

    Args:
        setting: the capture.
        step: by which the last effect was added.
        tuned: names of the effects whose parameters are fitted.
    """
    for _ in range(LAST_STEPS):
        if not (step.ends and _is_long(step, tuned)):
            break
        longer = _further(setting, step, tuned)
        worse = longer.left.whole.total > step.left.whole.total + step.left.held_error
        if worse or not longer.ends:
            break
        step = longer
    return step


def _further(setting: Setting, step: Step, tuned: Collection[str]) -> Step:
    """The step to a camera one step further on, by all that is known around this one.

    Steps of a calibration are made by a few twins and the frames that fit, and whatever these are
    off by chance goes into the camera. Around it there are many twins, all key frames, and the
    directions of this very place: of a gamma that was 3 standard errors off the first such step
    leaves 1.
    """
    model, amounts = step.model, step.left.amounts
    fit_half, _ = halves(setting.seen)
    now = refined(model.base, fit_half, model.scenery, model.effects)
    found = stepped(now, model.ways, amounts, fit_half, model.scenery, tuned=tuned)
    return step_to(setting, step.choice, around_it(found, model.scenery))


def _is_long(step: Step, tuned: Collection[str]) -> bool:
    """Whether a parameter would move by a good part of what it is known to."""
    knobs = len(step.model.ways.knobs)
    steps = zip(
        step.model.ways.tuned, step.left.amounts[knobs:], step.left.errors[knobs:], strict=False
    )
    return any(abs(by) > LONG * error for handle, by, error in steps if handle.effect in tuned)
