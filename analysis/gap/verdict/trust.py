"""How far to believe a name that is given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.gap.measure.measured import Measured
from analysis.gap.ready.setting import Setting
from analysis.gap.report import Gap, Verdict
from analysis.gap.search.choice import (
    DRAWN,
    LEAST_SHRINK,
    MAY_BE_NOTHING,
    MOST_CAUSES,
    TELLS_LITTLE,
    Choice,
)
from analysis.gap.search.closing import HARDLY_CHANCE, closed, nothing_left
from analysis.gap.search.later import LEADS, LITTLE_IS_LEFT
from analysis.gap.search.trail import Trail
from analysis.gap.verdict.caps import most_of, most_of_a_converter, most_of_a_shape

DOUBT = 0.45
"""Factor of a probability that is to stay below one half: of suspects none of which may be named,
and of effects that were added to another one without closing the gap."""

LIKELIER = 0.5
"""Probability below which an effect is likelier not the one. Where something is left besides, it
is no explanation: of twelve such names of the bench (seeds 12, 13, 20 and 21) eight were wrong,
seven of them for an effect that was withheld."""

LATER = 0.75
"""Factor of the probability of an effect that was added to another one, where nothing is left with
both: on the sets where this was tuned 4 of 4 such effects were right, and none of 6 where something
was left. No more is taken from the first one: of two as large as each other each closes half."""

IN_PAIR = 0.6
"""The same of each of two that together leave next to nothing, in no family beyond doubt, where
each closes a quarter of the gap or more. Of the bench (seeds 21 to 39) three such answers had both
names right or in class; a noise of rows beside a sharpening by somebody else, which close 0.55 and
0.44 of G 11, had 0.4 each, likelier wrong than right, and so no name."""

THE_REST = 0.1, 0.9
"""Part of the gap that a second one closes, and of what the first left, from which it is one of two
all the same. In a camera by another engineer the same two close 0.81 and 0.175 of G 11.8, which is
0.93 of what noise of rows leaves."""

A_RIVAL = 0.2
"""Part of what a first effect takes off chi-squared which the next suspect takes off at most, where
the first one stands out and is named whatever is left, if it closes `LEAST_SHRINK` of the gap. Of
the bench (seeds 23 to 43) and other engineers' cameras eight such effects had no name, because what
stood beside them had none, or three were there: each was right. The nearest wrong one, steps of a
converter for bits that are lost, has a rival with a quarter."""

OF_ONE_THAT_STANDS_OUT = 0.6
"""Probability of its name: what is wrong besides has a part in it."""

SMALL = 0.3
"""G below which a gap is small too, if what is left of it is beyond doubt: of four first names of
the bench (seeds 25, 44 and 48) to which that happened one was right."""

LEAST_TRUST = 0.4
"""Factor of the probability of an effect that closes no more of the gap than it must, where
something is left."""


def probability_of(place: int, word: Verdict, gap: Gap, found: Trail, setting: Setting) -> float:
    """Probability that an effect which is named is the one.

    Args:
        place: of the effect among those that are named.
        word: the verdict.
        gap: without and with the effects.
        found: from the base camera to the last model.
        setting: the capture.
    """
    choices = found.choices
    alone = closed(gap.before, found.measured[1].held.total)
    trust = by_what_is_left(word, gap, alone, place, len(choices))
    if is_a_pair(found.measured):
        trust = max(trust, IN_PAIR)
    most = most_of(place, word, gap, found, setting)
    return min(most, beside(choices[place], choices) * trust)


def is_a_pair(measured: Sequence[Measured]) -> bool:
    """Whether two effects leave next to nothing of a gap of which each closes a quarter or more, or
    the second one a good part and nearly all that the first one left.

    Args:
        measured: the capture against the models without any effect, with the first, and so on.
    """
    if len(measured) != MOST_CAUSES + 1:
        return False
    base, first, both = measured
    gap = base.held.total
    alone = closed(gap, first.held.total)
    later = closed(gap, both.held.total) - alone
    least, nearly_all = THE_REST
    the_rest = later >= least and closed(first.held.total, both.held.total) >= nearly_all
    return alone >= LEADS and (later >= LEADS or the_rest) and nothing_left(base, both)


def stands_out(lead: Trail, setting: Setting) -> float:
    """Probability of the name of a first effect that closes most of a gap of which no other suspect
    closes much, whatever is left; 0 where it is not so. One that was tried and leaves far more
    closes nothing that the first one does not.

    Args:
        lead: up to that effect, as it was found.
        setting: the capture.
    """
    base, after = lead.measured
    (choice,) = lead.choices
    known = {choice.best.name, *(one.name for one in choice.alike), *choice.beaten}
    others = [c.forward for c in lead.candidates if c.name not in known]
    much = base.held.total > LITTLE_IS_LEFT
    closes = closed(base.held.total, after.held.total) >= LEAST_SHRINK
    if not (much and closes and max(others, default=0.0) < A_RIVAL * choice.best.forward):
        return 0.0
    model = lead.models[-1]
    effect = model.effects[-1]
    most = min(
        most_of_a_shape(effect, model.scenery.body),
        most_of_a_converter(effect, model.effects, setting),
    )
    return min(OF_ONE_THAT_STANDS_OUT, choice.probability, most)


def no_surer(chances: Sequence[float], told: Sequence[bool]) -> list[float]:
    """Probabilities of names, none of which is surer than the one that it was found beside, but for
    what the frames tell.

    What is left of a wrong name is explained by whatever mends it: of two taps of unequal gain a
    spectral response had 0.75 beside a pattern that had 0.34.

    Args:
        chances: of the names, in the order in which they were added.
        told: of each whether it is lost bits that the frames tell.
    """
    return [
        chance if known else min(chance, *chances[:1])
        for chance, known in zip(chances, told, strict=True)
    ]


def likelier_none(choices: Sequence[Choice], chances: Sequence[float]) -> bool:
    """Whether every name that is given is likelier wrong, even if all that these frames do not tell
    from it were as likely.

    Args:
        choices: what is named.
        chances: the probability of each.
    """
    together = [
        chance * (1 + len(choice.alike)) for choice, chance in zip(choices, chances, strict=True)
    ]
    return all(chance < LIKELIER for chance in together)


def beside(choice: Choice, choices: Sequence[Choice]) -> float:
    """Probability of a name among those that are not named with it: who has a part of the gap is no
    rival for the rest. That of a drawn pattern is doubted whoever is named with it.

    Args:
        choice: the name.
        choices: all that are given, it among them.
    """
    if choice.best.name in DRAWN:
        return choice.probability
    named = {one.best.name for one in choices} - {choice.best.name}
    rivals = sum(choice.by_name.get(name, 0.0) for name in named)
    return min(1.0, choice.probability / max(1.0 - rivals, choice.probability))


def by_what_is_left(word: Verdict, gap: Gap, alone: float, place: int, count: int) -> float:
    """Factor of the probability of an effect, by what is left with it.

    Of a small gap the part that is closed tells little. Where something is left of one, of seven
    first names of the bench (seeds 21 to 47) that had half or more for the lost digits of its
    chance one was right.

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
    beyond_doubt = gap.p_value_after < HARDLY_CHANCE
    small = gap.before < (SMALL if beyond_doubt else TELLS_LITTLE)
    if word == "explained" and (count == 1 or small):
        return 1.0
    if count == 1 and gap.p_value_after > MAY_BE_NOTHING:
        return LATER
    if small:
        return DOUBT
    beyond = float(np.clip((alone - LEAST_SHRINK) / (1 - LEAST_SHRINK), 0, 1))
    least = LATER if word == "explained" else LEAST_TRUST
    return least + (1 - least) * beyond
