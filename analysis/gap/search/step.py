"""A step from one model to the next: an effect that is added, and what the model with it leaves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from analysis.gap.calibrate.fit import Fit, around
from analysis.gap.calibrate.refine import Refined, as_shown
from analysis.gap.camera.twin import Scenery
from analysis.gap.measure.measured import Measured, measured
from analysis.gap.ready.setting import Setting
from analysis.gap.search.choice import SIGNIFICANCE, TELLS_LITTLE, Choice

Watch = Callable[[str], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """An effect that was added: what is said of it, the model with it, and what that leaves;
    `ends` where nothing more is to be added.
    """

    choice: Choice
    model: Fit
    left: Measured
    ends: bool


def step_to(setting: Setting, choice: Choice, model: Fit) -> Step:
    """The step to a model with a suspect in it."""
    left = measured(model, setting.seen)
    return Step(choice=choice, model=model, left=left, ends=left.whole.p_value >= SIGNIFICANCE)


def around_it(found: Refined, scenery: Scenery) -> Fit:
    """Everything around a model, under light as the frames show it to a camera like that."""
    return around(found.base, as_shown(found, scenery), found.effects)


def nearer(one: Step, other: Step) -> Step:
    """The step that leaves less; if both leave little, the one whose worst family is likelier."""
    first, second = one.left, other.left
    if max(first.held.total, second.held.total) < TELLS_LITTLE:
        closer = min(second.whole.p_by_family.values()) > min(first.whole.p_by_family.values())
    else:
        closer = second.held.total < first.held.total
    return other if closer else one
