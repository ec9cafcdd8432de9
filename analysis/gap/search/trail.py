"""From the base camera to the last model, and how far each of them is from the capture."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from analysis.gap.calibrate.fit import Fit
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured
from analysis.gap.report import Gap
from analysis.gap.search.choice import SIGNIFICANCE, Choice
from analysis.gap.search.closing import closed, untouched


@dataclass(frozen=True, kw_only=True, eq=False)
class Trail:
    """From the base camera to the last model.

    Attributes:
        models: the base, and the base with each effect that was added.
        measured: the capture's distance from each of them.
        choices: what was named, in the order it was added.
        candidates: the suspects of the base's gap, best first.
        p_before, p_after: chance of the gap from the first model and from the last.
        lead: the same with the effect alone that was added before any other, as it was found; None
            where none was.
    """

    models: tuple[Fit, ...]
    measured: tuple[Measured, ...]
    choices: tuple[Choice, ...]
    candidates: tuple[Candidate, ...]
    p_before: float
    p_after: float
    lead: Trail | None = None

    def first(self) -> Trail:
        """The base alone."""
        return Trail(
            models=self.models[:1],
            measured=self.measured[:1],
            choices=(),
            candidates=self.candidates,
            p_before=self.p_before,
            p_after=self.p_before,
        )


def still_untouched(found: Trail, told: Collection[str]) -> bool:
    """Whether something that is wrong beyond doubt is as it was, and speaks against the effects.

    What whole codes tell is so, whatever else is wrong with the camera.

    Args:
        found: from the base camera to the last model.
        told: names of the effects that whole codes tell.
    """
    if any(effect.name in told for effect in found.models[-1].effects):
        return False
    return bool(untouched(found.measured[0], found.measured[-1]))


def gap_of(found: Trail) -> Gap:
    """Distances on the frames that score, and how much of them the added effects close."""
    before, after = found.measured[0], found.measured[-1]
    floor, b, a = before.floor, before.held.total, after.held.total
    se_before, se_after = before.held_error, after.held_error
    span = b - floor
    shrink = closed(b, a, floor)
    error = float(np.hypot(se_after, se_before * (a - floor) / span) / abs(span)) if span else 0.0
    total = float(before.rod.spread.expected.sum())
    named = {one.name for c in found.choices for one in (c.best, *c.alike)}
    wrong = [c.forward / total / span for c in found.candidates if c.name not in named and span > 0]
    families = {
        name: {
            "before": before.held.by_family[name],
            "after": after.held.by_family.get(name, 0.0),
            "p_value": before.whole.p_by_family[name],
        }
        for name in before.held.by_family
    }
    worse = {n: f["after"] - f["before"] for n, f in families.items()}
    harmed = max(worse, key=lambda n: worse[n]) if found.choices else None
    if harmed is not None and after.whole.p_by_family.get(harmed, 1.0) > SIGNIFICANCE / 10:
        harmed = None
    return Gap(
        before=b,
        after=a,
        floor=floor,
        shrink=shrink,
        shrink_ci=(shrink - 1.96 * error, shrink + 1.96 * error),
        at_floor=bool(span < 2 * np.hypot(se_before, se_after)),
        p_value_before=found.p_before,
        p_value_after=found.p_after,
        by_family=families,
        harmed=harmed,
        placebo=float(np.median(wrong)) if wrong else 0.0,
    )
