"""How every suspect would show: all of them with one set of random numbers, some with a second.

The difference of two twins with the same random numbers still has noise, and most suspects are out
of the question with it as well as without. Held against a capture family by family, each with an
amount of its own, a signature takes off at least what it would take off as a whole,

    sum over families of (r_f . g_f)^2 / |r_f|^2  >=  (r . g)^2 / |r|^2,    by Cauchy and Schwarz,

and noise in one family condemns no other. Only those that promise something by this bound are
looked at once more, and keep what both looks agree on.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np

from analysis.gap.calibrate.agreement import agreed_of
from analysis.gap.calibrate.fit import SEEDS, Fit
from analysis.gap.measure.case import Case, vector
from analysis.gap.measure.signature import (
    Signature,
    begun_signature,
    scaled,
    signed,
    starts,
)
from analysis.gap.ready.hints import DirectReading, Hints
from foundation.cores import ahead
from sensor.colours import Colours
from sensor.effect import Effect, Stage

WORTH_A_SECOND = 14.0
"""Promise that is worth a second look: a suspect needs a score of 15 to be named, and families
promise half of that by chance."""

LITTLE = 200.0
"""Chi-squared of a signature that is seen well, and that a capture may have where nothing else is
off."""

WEAKER = 0.3
"""Part of the strength from which a search begins below which another look is worth it."""

WEAKEST = 0.05
"""The same below which a length says nothing: a filter in space of 0.6 takes all noise of a camera
that is quieter than a code, and is a hundred million times as long as one of 0.07, which is no part
of it."""

NEARLY_FITS = 1.5
"""Misfit up to which that look is taken. Such a camera had 1.25 behind a blur of 0.067, which was
unexplained for it (the set of withheld effects of seed 22)."""

IN_THE_PICTURE = frozenset({Stage.LIGHTING, Stage.OPTICS, Stage.PHOTOSITE})
"""Stages whose effects change what there is to see."""

PROMISING = 0.05
"""Part of the best promise that is worth a second look: a suspect is a finalist from a fifth of the
best score on (`attribute.NEAR`), which leaves room for the noise of one set."""


def shows(
    case: Case,
    kinds: Iterable[type[Effect]],
    hints: Mapping[str, Hints],
    told: Mapping[str, DirectReading],
    watch: Callable[[str], None] = lambda name: None,
) -> list[Signature]:
    """How every suspect would show at every strength and shape from which a search begins, by one
    set of random numbers; see `closer`.

    Args:
        case: the capture.
        kinds: the suspects.
        hints: where the search for a parameter begins, by name of the effect.
        told: parameters that the frames tell, the same.
        watch: told whose turn it is.
    """

    def begun() -> Iterator[Callable[[], Signature | None]]:
        for kind in kinds:
            watch(kind.name)
            exact = told[kind.name].hints if kind.name in told else {}
            hinted = in_range(kind, {**hints.get(kind.name, {}), **exact})
            first = (dataclasses.replace(e, **hinted) for e in starts(kind))
            for effect in dict.fromkeys(way for e in first for way in either_way(e)):
                yield begun_signature(effect, case.known, seeds=SEEDS[:1])

    return [shown for shown in ahead(begun()) if shown is not None]


def weaker(
    case: Case, shown: Iterable[Signature], watch: Callable[[str], None] = lambda name: None
) -> list[Signature]:
    """How what is done to pictures would show where it does as little as could be off at most.

    Whole numbers that are weighed with a hundredth of their neighbours change only where they were
    about halves, and that looks like nothing that a third of them does.

    Args:
        case: the capture.
        shown: by one set of random numbers, at the strengths from which a search begins.
        watch: told whose turn it is.
    """
    if case.misfit > NEARLY_FITS:
        return []
    turned = case.fitting.turned

    def much(one: Signature) -> float:
        return float(np.square(turned.left(vector(turned.space, one))).sum())

    pictures = [one for one in shown if one.effect.stage is Stage.PROCESSING]
    parts = {one.effect: np.sqrt(LITTLE / max(much(one), LITTLE)) for one in pictures}
    weak = [
        scaled(effect, max(float(part), WEAKEST)) for effect, part in parts.items() if part < WEAKER
    ]

    def begun() -> Iterator[Callable[[], Signature | None]]:
        for effect in weak:
            watch(effect.name)
            yield begun_signature(effect, case.known, seeds=SEEDS[:1])

    return [one for one in ahead(begun()) if one is not None]


def either_way(effect: Effect) -> tuple[Effect, ...]:
    """An effect, and the same the other way where there is one.

    The picture turns its sign with a shift of colours or a change of the light; the power of what
    calibration leaves of it does not, and is no evidence for an amount below zero.
    """
    if not signed(type(effect)) or effect.stage not in IN_THE_PICTURE:
        return (effect,)
    return effect, scaled(effect, -1.0)


def closer(
    case: Case,
    shown: Sequence[Signature],
    watch: Callable[[str], None] = lambda name: None,
    *,
    least: float = WORTH_A_SECOND,
) -> list[Signature]:
    """Signatures in their order; of those that promise something, what both sets of random numbers
    agree on.

    Args:
        case: the capture.
        shown: signatures at this model or at one before it.
        watch: told whose turn it is.
        least: promise that a second look needs in any case.
    """
    keys = case.fitting.turned.space.keys
    promised = [promise(case, one.on(keys)) for one in shown]
    least = max(least, PROMISING * max(promised, default=0.0))
    worth_it = [
        much >= least and one.sets < len(SEEDS) for one, much in zip(shown, promised, strict=True)
    ]

    def begun() -> Iterator[Callable[[], Signature | None]]:
        for one in itertools.compress(shown, worth_it):
            watch(one.effect.name)
            yield begun_signature(one.effect, case.known, seeds=SEEDS[1:])

    second = iter(list(ahead(begun())))
    return [
        confirmed(one, next(second), case.known) if again else one
        for one, again in zip(shown, worth_it, strict=True)
    ]


def promise(case: Case, shown: Signature) -> float:
    """By how much chi-squared would fall if every family had its own amount of a signature."""
    turned = case.fitting.turned
    families, place = np.unique(case.fitting.spread.families, return_inverse=True)
    remains = turned.left(vector(turned.space, shown))[: len(place)]
    along = np.bincount(place, remains * case.fit_left[: len(place)], len(families))
    norm = np.bincount(place, remains * remains, len(families))
    if not signed(type(shown.effect)):
        along = np.maximum(along, 0.0)
    return float(np.sum(np.square(along) / np.maximum(norm, 1e-300)))


def confirmed(first: Signature, second: Signature | None, known: Fit) -> Signature:
    """What a second set of random numbers agrees on with the first.

    Args:
        first: by one set, at this model or at one before it.
        second: by the other; None where these frames cannot have the effect.
        known: the model.
    """
    if second is None:
        return first
    first = first.on(second.keys)
    figures, means = agreed_of(
        np.array([first.figures, second.figures]),
        np.array([first.means, second.means]),
        known.references[SEEDS[0]],
    )
    plain = (first.plain[0] + second.plain[0]) / 2, (first.plain[1] + second.plain[1]) / 2
    return dataclasses.replace(second, figures=figures, means=means, plain=plain, sets=len(SEEDS))


def in_range(kind: type[Effect], hints: Hints) -> dict[str, float | Colours]:
    """What is hinted of an effect's parameters, as far as each may go: frames may say more.

    Args:
        kind: the effect.
        hints: by name of the parameter; others are left out.
    """
    found: dict[str, float | Colours] = {}
    for p in kind.parameters():
        if p.name in hints:
            value = hints[p.name]
            found[p.name] = value.map(p.clipped) if isinstance(value, Colours) else p.clipped(value)
    return found
