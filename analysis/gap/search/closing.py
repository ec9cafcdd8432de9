"""How much of a gap a model closes, and whether it closes it where it was."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.texture import FAMILY as TEXTURE
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.distance import Distance
from analysis.gap.measure.measured import Measured
from analysis.gap.measure.twins_spread import believed
from analysis.gap.search.choice import SIGNIFICANCE, TELLS_LITTLE

Floats = NDArray[np.float64]

TOO_WIDE = -0.3
"""G below which a model expects far more than these frames show: one body of it would not be so
like another one as this capture is like its own picture. Right models have 0 within 0.1."""

LARGE = 0.1
"""A gap from which the part of it that a suspect takes off means something."""

LEAST_PART = 0.12
"""Part of a large gap that the signature of a suspect takes off. A pattern that is another one in
every body makes every expectation wide, and would close any gap of the picture by that alone."""

CERTAIN = 1e-20
"""Chance of a family below which it is beyond doubt that something is wrong with it."""

LEAST_OF_A_FAMILY = 0.3
"""Part of the gap of such a family that a model closes if it has the cause: right effects of other
people's code close 0.5 of each or more, most wrong ones that close a total leave one as it was."""


def closed(before: float, after: float, floor: float = 0.0) -> float:
    """Part of the gap above the floor that is closed."""
    return (before - after) / (before - floor) if before != floor else 0.0


def too_wide(left: Measured) -> bool:
    """Whether a model expects far more than frames show, and more than chance makes: where bodies
    differ by a few photosites, most of them show less than their mean.
    """
    return left.held.total < min(TOO_WIDE, -left.held_error)


def accounts(found: Candidate, now: Measured, after: Measured) -> bool:
    """Whether it is the suspect's own doing that closes the gap, and not the width it gives to all.

    Its signature takes a part of the gap off; or, if it makes figures scatter, which by the errors
    of a model without it leaves more than there was, the figures of the frames are likelier with
    it. The picture has a say in that where nothing is left: a pattern is wide enough for whatever
    is wrong with a picture, but does not look like it.

    Args:
        found: the suspect.
        now, after: the capture against the models without it and with it.
    """
    gap = now.held.total
    expected = float(now.case.fitting.spread.expected.sum())
    taken = float(np.square(now.case.fit_left).sum()) / expected - found.misfit
    whole = float(now.rod.spread.expected.sum())
    of_picture = after.whole.p_value >= SIGNIFICANCE
    likelier = _fall(now, after, of_picture) / whole
    return gap < LARGE or max(taken, likelier) > LEAST_PART * gap


def _fall(before: Measured, after: Measured, of_picture: bool) -> float:
    """By how much -2 log likelihood falls, over the figures that both models have.

    Args:
        before, after: the capture against both, each by its own errors.
        of_picture: whether texture and blocks count.
    """
    keys, others = (one.rod.turned.space.keys for one in (before, after))
    first, second = _deviances(before), _deviances(after)
    there = {key: place for place, key in enumerate(others)}
    places = [
        (place, there[key])
        for place, key in enumerate(keys)
        if key in there and (of_picture or key.family != TEXTURE)
    ]
    fall = sum(float(first[one] - second[other]) for one, other in places)
    of_blocks = float(first[len(keys) :].sum() - second[len(others) :].sum())
    return fall + of_blocks if of_picture else fall


def _deviances(one: Measured) -> Floats:
    """-2 log likelihood of each figure and each block, by the model's own errors."""
    z = believed(one.left[: len(one.rod.spread.families)], len(one.rod.spread.residuals))
    return np.asarray(np.square(z) + 2.0 * one.rod.turned.space.log_widths)


WORTH_CLOSING = 0.02
"""Part of the whole excess below which a family is not held against a model: one that is right to a
tenth leaves a hundredth of chi-squared."""


def untouched(before: Measured, after: Measured, worth: float = WORTH_CLOSING) -> tuple[str, ...]:
    """Families that were off beyond doubt and that a model leaves as they were.

    The total is mostly of the families that have most figures: an effect may close all of it and
    have nothing to do with what is wrong in another one.

    Args:
        before, after: the capture against the models without and with the effects.
        worth: part of the whole excess from which a family counts.
    """
    spread = before.rod.spread
    expected = dict(zip(spread.names, map(float, spread.expected), strict=True))
    return left_as_they_were(before.whole.p_by_family, before.held, after.held, expected, worth)


def left_as_they_were(
    chances: Mapping[str, float],
    before: Distance,
    after: Distance,
    expected: Mapping[str, float],
    worth: float = WORTH_CLOSING,
) -> tuple[str, ...]:
    """Families that were off beyond doubt and that a model leaves as they were, by their distances.

    Args:
        chances: of each family without the effects.
        before, after: distances without and with them.
        expected: chi-squared of each family where nothing is wrong.
        worth: part of the whole excess from which a family counts.
    """
    least = worth * before.total * sum(expected.values())
    return tuple(
        name
        for name, chance in chances.items()
        if chance < CERTAIN
        and after.by_family[name] * expected[name] > least
        and closed(before.by_family[name], after.by_family[name]) < LEAST_OF_A_FAMILY
    )


LITTLE = 0.05
"""Part of the gap that is left to chance and to the model's own errors: no one else is blamed."""


def nothing_left(before: Measured, after: Measured) -> bool:
    """Whether so little of a gap is left, in every family, that nobody else is blamed for it.

    Near the floor no part of a gap says anything, and chances do. A family that speaks against the
    effects beyond doubt may have another cause, however little it is of a large gap: of that of
    lost bits an interference is a hundredth, and of that of a vibration much light in darks.

    Args:
        before, after: the capture against the models without and with the effects.
    """
    gap = before.held.total
    little = gap > TELLS_LITTLE and after.held.total < LITTLE * gap
    return little and not against(before, after)


SPOILT = 3.0
"""By how much G of a family must rise for a model to have spoilt it; it rises by less where a right
effect has not quite its strength."""


LINGERS = 0.1
"""Part of the gap of the family that was most off. Whoever has the cause leaves less of it: where
this was tuned 12 of 15 right names beside which something was left had 6 % of it or less, and three
more than a tenth; of 5 wrong names four had."""

LINGERS_AT_LEAST = 3.0
LINGERS_OF_MOST = 0.03
"""G of that family from which it lingers, or this part of what it was where that is more: of a
dozen more right names ten left less than half of this, and one 3.4 of 144, for a formula that is
nearly the right one; roots of the codes, taken for a converter's steps, left 10 of 207."""

MOST_LINGERS = 0.3
HARDLY_CHANCE = 1e-6
"""A gap near its floor is beyond doubt in no family. What keeps so much of the one that was most
off, and not by chance, has not the cause either: an image lag that was named for a temporal filter
kept a third of it, and 10 right names 14 % at most. Of other families right names left no such
part at a G of 3 and beyond doubt. A table of codes, behind everything, was twice named as errors of
a converter, which lie before the colours: where these are filled in 0.55 and 0.32 were left."""


def against(before: Measured, after: Measured) -> tuple[str, ...]:
    """Families that speak against a model: untouched or spoilt by it, however small they are, and
    those that linger.

    Whoever has the cause leaves part of what it does, for want of the right formula. What it does
    not do it leaves alone.

    Args:
        before, after: the capture against the models without and with the effects.
    """
    left = untouched(before, after, worth=0.0)
    wrong = (*left, *spoilt(before.held, after.whole), *lingering(before.whole, after.whole))
    return tuple(dict.fromkeys(wrong))


def lingering(before: Distance, after: Distance) -> tuple[str, ...]:
    """Families of which a model leaves a third, and the one that was most off, where it leaves much
    of that, each beyond doubt.

    One of few figures may be off by more, and by chance: it is no witness where another one is.

    Args:
        before, after: distances without and with the effects.
    """
    sure = [name for name, chance in before.p_by_family.items() if chance < CERTAIN]
    most = max(sure or before.by_family, key=lambda name: before.by_family[name])

    def lingers(name: str) -> bool:
        was, left = before.by_family[name], after.by_family.get(name, 0.0)
        chance = after.p_by_family.get(name, 1.0)
        if name != most:
            return left > max(LINGERS_AT_LEAST, MOST_LINGERS * was) and chance < CERTAIN
        least = min(LINGERS * was, max(LINGERS_AT_LEAST, LINGERS_OF_MOST * was))
        much = left > least and chance < CERTAIN
        return much or (left > MOST_LINGERS * was and chance < HARDLY_CHANCE)

    return tuple(filter(lingers, dict.fromkeys([most, *sure])))


def spoilt(before: Distance, after: Distance) -> tuple[str, ...]:
    """Families that are wrong beyond doubt with a model, and were not as wrong without it.

    Args:
        before, after: distances without and with the effects.
    """
    return tuple(
        name
        for name, chance in after.p_by_family.items()
        if chance < CERTAIN and after.by_family[name] > before.by_family.get(name, 0.0) + SPOILT
    )
