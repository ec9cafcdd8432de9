"""The report of what was found: the word, the figures, and how far to believe them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.gap.calibrate.calibration_figures import calibration_figures
from analysis.gap.calibrate.fit import Fit
from analysis.gap.camera.handles import Handle
from analysis.gap.look.shots import FEWEST_FRAMES, FEWEST_SHOTS, GROUP_FRAMES
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured
from analysis.gap.ready.setting import Setting
from analysis.gap.report import NO_GAP, Figure, Gap, GapReport, Named, Suspect
from analysis.gap.verdict.closing import against, closed, untouched
from analysis.gap.verdict.places import places
from analysis.gap.verdict.verdict import (
    EQUIVALENT,
    LEAST_SHRINK,
    SIGNIFICANCE,
    Choice,
    next_capture,
    probabilities,
    verdict,
)
from sensor.colours import CHANNELS, Colours
from sensor.effect import Parameter

DOUBT = 0.45
"""Factor of a probability that is to stay below one half: of suspects none of which may be named,
and of effects that were added to another one without closing the gap."""

MOST_CERTAIN = 0.95
MOST_IN_PART = 0.85
"""Probabilities that no name passes, where nothing is left with it and where something is. On four
sets of withheld effects 35 of 39 names were right that were given with 0.99 in the one case, and 16
of 23 in the other: what is in no catalogue may look like what is."""

MOST_AGAINST = 0.45
"""The same where something speaks against the model beyond doubt: likelier not than so."""

LATER = 0.75
"""Factor of the probability of an effect that was added to another one, where nothing is left with
both: on the sets where this was tuned 4 of 4 such effects were right, and none of 6 where something
was left. No more is taken from the first one: of two as large as each other each closes half."""

LEAST_TRUST = 0.4
"""Factor of the probability of an effect that closes no more of the gap than it must, where
something is left."""


TELLS_LITTLE = 0.1
"""G below which the part of it that is closed says nothing of who closed it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trail:
    """From the base camera to the last model.

    Attributes:
        models: the base, and the base with each effect that was added.
        measured: the capture's distance from each of them.
        choices: what was named, in the order it was added.
        candidates: the suspects of the base's gap, best first.
        p_before, p_after: chance of the gap from the first model and from the last.
    """

    models: tuple[Fit, ...]
    measured: tuple[Measured, ...]
    choices: tuple[Choice, ...]
    candidates: tuple[Candidate, ...]
    p_before: float
    p_after: float

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


TOO_FEW = (
    f"fewer than {FEWEST_SHOTS} shots have {FEWEST_FRAMES} frames; {2 * GROUP_FRAMES} of each are"
    " needed to split them into frames that fit and frames that score"
)


def insufficient(trouble: str) -> GapReport:
    """The report of a capture that shows too little."""
    return GapReport(
        verdict="insufficient data",
        gap=NO_GAP,
        next_capture=f"darks and lit shots of {2 * GROUP_FRAMES} or more frames, not saturated",
        notes=(trouble,),
    )


def elsewhere(found: Trail, told: Collection[str]) -> bool:
    """Whether something that is wrong beyond doubt is as it was, and speaks against the effects.

    What whole codes tell is so, whatever else is wrong with the camera.

    Args:
        found: from the base camera to the last model.
        told: names of the effects that whole codes tell.
    """
    if any(effect.name in told for effect in found.models[-1].effects):
        return False
    return bool(untouched(found.measured[0], found.measured[-1]))


def conclude(setting: Setting, found: Trail) -> GapReport:
    """The report of what was found."""
    gap = gap_of(found)
    word = verdict(len(found.choices), gap, elsewhere(found, setting.told))
    if word == "unexplained":
        found = found.first()
        gap = gap_of(found)
    before, after = found.measured[0], found.measured[-1]
    doubt = 1.0 if found.choices or not found.candidates else DOUBT
    weights = found.choices[0].by_name if found.choices else probabilities(found.candidates)
    total = float(before.rod.spread.expected.sum())
    count = len(found.choices)
    alone = closed(gap.before, found.measured[min(1, count)].held.total)
    most = _most(word, found)
    return GapReport(
        verdict=word,
        effects=tuple(
            _named(
                choice,
                min(most, beside(choice, found.choices) * _trust(word, gap, alone, k, count)),
                found,
            )
            for k, choice in enumerate(found.choices)
        ),
        candidates=tuple(
            Suspect(
                name=c.name,
                probability=min(most, float(weights.get(c.name, 0.0)) * doubt),
                gap=before.held.total - c.forward / total,
                calibration_equivalent=c.absorbed > EQUIVALENT,
                score=c.score,
            )
            for c in found.candidates
        ),
        gap=gap,
        where=places(before.left, before.rod.turned.space, setting),
        next_capture=_wanted(word, found),
        calibration=calibration_figures(found.models[-1], after.errors),
        notes=notes_of(setting),
    )  # fmt: skip


def _most(word: str, found: Trail) -> float:
    """The probability that no name passes."""
    if word == "explained":
        return MOST_CERTAIN
    doubted = found.choices and against(found.measured[0], found.measured[-1])
    return MOST_AGAINST if doubted else MOST_IN_PART


def _wanted(word: str, found: Trail) -> str | None:
    """The capture that would tell more; None where it is not needed."""
    if word == "unexplained":
        return next_capture([c.name for c in found.candidates[:2]])
    confused = [[c.best.name, *(one.name for one in c.alike)] for c in found.choices if c.alike]
    return next_capture([name for names in confused for name in names]) if confused else None


def beside(choice: Choice, choices: Sequence[Choice]) -> float:
    """Probability of a name among those that are not named with it: who has a part of the gap is no
    rival for the rest.

    Args:
        choice: the name.
        choices: all that are given, it among them.
    """
    named = {one.best.name for one in choices} - {choice.best.name}
    rivals = sum(choice.by_name.get(name, 0.0) for name in named)
    return min(1.0, choice.probability / max(1.0 - rivals, choice.probability))


def _trust(word: str, gap: Gap, alone: float, place: int, count: int) -> float:
    """Factor of the probability of an effect, by what is left with it.

    Where something is left, the first one's model is not quite that of the camera, and whoever
    comes later may only be mending it: a sum of two may look like one that nobody knows.

    Args:
        word: the verdict.
        gap: without and with the effects.
        alone: part of the gap that the first one closes, whatever its floor: halves of the frames
            that differ from each other are a sign of something, too.
        place: of the effect among them.
        count: how many they are.
    """
    if place > 0:
        return LATER if word == "explained" else DOUBT
    if (count == 1 and word == "explained") or gap.before < TELLS_LITTLE:
        return 1.0
    beyond = float(np.clip((alone - LEAST_SHRINK) / (1 - LEAST_SHRINK), 0, 1))
    least = LATER if word == "explained" else LEAST_TRUST
    return least + (1 - least) * beyond


def _named(choice: Choice, probability: float, found: Trail) -> Named:
    best, model, after = choice.best, found.models[-1], found.measured[-1]
    effect = next(e for e in model.effects if e.name == best.name)

    def figure(p: Parameter) -> Figure:
        """After the last step of the fit, with a standard error where it was fitted."""
        own = getattr(effect, p.name)
        value = Colours.of(own).G
        channel = CHANNELS.index("G") if isinstance(own, Colours) else None
        handle = Handle(effect=effect.name, parameter=p.name, channel=channel)
        if handle not in model.ways.tuned:
            return Figure(value=value, se=None, unit=p.unit)
        place = len(model.ways.knobs) + model.ways.tuned.index(handle)
        error = float(after.errors[place])
        if not np.isfinite(error):
            return Figure(value=value, se=None, unit=p.unit)
        moved = last_step(p, value, float(after.amounts[place]))
        if p.identity is not None:
            error = max(error, least_error(p, moved, best.score))
        return Figure(value=moved, se=error, unit=p.unit)

    return Named(
        name=best.name,
        probability=probability,
        indistinguishable_from=tuple(c.name for c in choice.alike),
        absorbed=best.absorbed,
        parameters={p.name: figure(p) for p in effect.parameters()},
    )


def last_step(p: Parameter, value: float, by: float) -> float:
    """A parameter after the last step of the fit, inside its range.

    A strength is not moved to where the effect vanishes, or beyond: that there is one has been
    shown, and a step that says otherwise only says how little it knows.
    """
    moved = p.clipped(value + by)
    gone = p.identity is not None and (moved - p.identity) * (value - p.identity) <= 0
    return value if gone else moved


def least_error(p: Parameter, value: float, score: float) -> float:
    """Standard error below which no strength is known whose effect is seen with such a score.

    An effect that grows as the power r of its strength and is seen at z standard errors is known to
    1 / (r z) of its strength, and none here grows faster than a square. A strength that counts in
    octaves is the logarithm of a value.
    """
    assert p.identity is not None, "a strength has a value at which the effect vanishes"
    if p.in_octaves and value > 0:
        strength = value * float(np.log(value / p.identity))
    else:
        strength = value - p.identity
    return abs(strength) / (2.0 * float(np.sqrt(max(score, 1.0))))


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


def notes_of(setting: Setting) -> tuple[str, ...]:
    """What a reader must know of how the capture was used."""
    notes = [f"light: {setting.scenery.light.source}"]
    if not setting.scenery.light.known and setting.capture.lit:
        notes.append("the picture itself is not judged, only what differs between shots of a lamp")
    if setting.plan.other:
        notes.append(f"not looked at, they would show the same: {', '.join(setting.plan.other)}")
    if setting.plan.unused:
        notes.append(f"too few frames to be used: {', '.join(setting.plan.unused)}")
    return tuple(notes)
