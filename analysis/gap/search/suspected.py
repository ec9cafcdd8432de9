"""The suspects of what a model leaves, and which of them may be evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from analysis.gap.calibrate.fit import Fit
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured
from analysis.gap.measure.signature import Signature
from analysis.gap.ready.hints import DirectReading, Hints
from analysis.gap.search.choice import both, p_of_best, telling
from analysis.gap.search.step import Watch
from analysis.gap.suspects.attribute import attribute
from analysis.gap.suspects.direct_readings import hints_of
from analysis.gap.suspects.first_look import closer, shows, weaker
from sensor.effect import Effect


@dataclass(frozen=True, kw_only=True, eq=False)
class Heard:
    """What the frames tell: of which suspects, and where the search for others begins."""

    told: Mapping[str, DirectReading]
    hints: Mapping[str, Hints]


@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
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


def looked(
    model: Fit,
    now: Measured,
    kinds: Sequence[type[Effect]],
    shown: Sequence[Signature],
    heard: Heard,
    watch: Watch,
) -> Look:
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
    return Look(
        shown=tuple(seen),
        candidates=tuple(candidates),
        telling=tuple(evidence),
        chance=both(now.whole.p_value, by_best),
    )
