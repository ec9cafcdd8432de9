"""How a camera counts between its converter and what leaves it, told by which twins fit.

Codes of one value in 17 sixteenths and of the next in 15 belong to a camera of 12 bits that gives 8
and are no fault of its converter, though they are not equally wide. With a white balance in between
they are told by where they end: see `look.finer_codes`.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Iterator, Sequence

import numpy as np

from analysis.gap.calibrate.refine import FAR, Refined, further, refined
from analysis.gap.camera.base import Base, channels_alike
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.arithmetic import (
    FINER,
    IN_FRACTIONS,
    OF_64THS,
    UP,
)
from analysis.gap.look.families import INTERPOLATION
from analysis.gap.look.finer_gains import Gains
from analysis.gap.look.observation import Observation

UNEVEN = 3.5
"""Mean square of what is left of the histograms, in standard errors, that is no chance: of seven
figures it is one in a thousand times."""

LIKELIEST = 2
"""Ways of counting in finer codes that are calibrated: their black levels differ a little."""

EVENER = 0.5
"""Part of the unevenness that finer codes leave where they are its cause."""


def counted(found: Refined, seen: Observation, scenery: Scenery, enough: float = FAR) -> Refined:
    """The camera with the arithmetic of its demosaicer that fits best; the same where it fits.

    Processing behind a demosaicer that counts in whole numbers hides from `arithmetic_of` that it
    does.

    Args:
        found: a camera against the frames.
        seen: the frames that fit.
        scenery: their light and shots.
        enough: misfit from which others are tried.
    """
    if found.misfit < enough:
        return found
    others = (
        refined(by_rule(found.base, rule), seen, scenery, found.effects)
        for rule in scenery.rules
        if rule != found.base.arithmetic
    )
    return min([found, *others], key=lambda one: one.chi2)


def by_rule(base: Base, rule: int) -> Base:
    """The camera with another way of counting, and codes that are as high in the mean."""
    raised = UP.get(rule, 0.0) - UP.get(base.arithmetic, 0.0)
    return dataclasses.replace(base, arithmetic=rule, black_dn=base.black_dn - raised)


def balanced(base: Base, gains: Gains) -> Base:
    """The camera with gains behind its converter. Where it counts in finer codes its converter is
    the same for all colours.
    """
    made = base.plain().multiplied(gains.white_balance, gains.origin_dn)
    return channels_alike(made) if base.arithmetic in FINER else made


def with_likelier_gains(
    found: Refined, seen: Observation, scenery: Scenery, gains: Sequence[Gains]
) -> Refined:
    """The camera with other gains that its codes leave open, where its twins fit better.

    All are held against the frames with one converter for all colours: a camera that was calibrated
    with the wrong ones has taken up what is wrong with them in a gain of its own for each colour.

    Args:
        found: calibrated with the first of them.
        seen: the frames that fit.
        scenery: their light and shots.
        gains: behind its converter.
    """
    if len(gains) < 2:
        return found
    alike = [refined(balanced(found.base, one), seen, scenery, found.effects) for one in gains]
    best = min(alike, key=lambda one: one.chi2)
    return found if best is alike[0] else further(best, seen, scenery)


def without_gains(found: Refined, seen: Observation, scenery: Scenery) -> Refined:
    """The camera without the gains that combs of its whole codes seem to tell, where its twins fit
    better: waves over the picture make a comb as well. Combs of finer codes are told by pixels.

    Args:
        found: a calibrated camera.
        seen: the frames that fit.
        scenery: their light and shots.
    """
    if found.base.white_balance is None or found.base.arithmetic in FINER:
        return found
    plain = refined(found.base.plain(), seen, scenery, found.effects)
    return found if plain.chi2 > found.chi2 else further(plain, seen, scenery)


def in_finer_codes(found: Refined, seen: Observation, scenery: Scenery) -> Refined:
    """The camera with a converter of more bits than leave it, where that is why codes are uneven
    and it is likelier by all figures. Those of a histogram go together: one dark whose few codes
    are off by chance is off in many of them.

    Where more than the histograms is wrong, whatever makes them uneven as well may be the cause,
    but for a converter with which those of all darks are even: no light reaches these.

    Args:
        found: a calibrated camera.
        seen: the frames that fit.
        scenery: their light and shots.
    """
    by_darks = found.misfit > FAR
    if (uneven_in_the_dark if by_darks else unevenness)(found) < UNEVEN:
        return found
    against = (refined(base, seen, scenery, found.effects) for base in finer(found.base, scenery))
    likely = [
        one
        for one in sorted(against, key=unevenness)[:LIKELIEST]
        if not by_darks or uneven_in_the_dark(one) < UNEVEN
    ]
    tried = [further(one, seen, scenery) for one in likely]
    best = min([found, *likely, *tried], key=unevenness)
    halved = unevenness(best) < EVENER * unevenness(found)
    return best if halved and best.deviance < found.deviance else found


def unevenness(found: Refined) -> float:
    """Mean square of what is left of the histograms of codes and of what stands between measured
    samples, in standard errors: of that channel, in the dark or in the light, of which it is most.
    Gains make combs in red and in blue alone, and few codes of a dark show more of them than many
    lit ones, whose combs are averaged.
    """
    return max((float(np.mean(np.square(z))) for z in _of_codes(found).values()), default=0.0)


def uneven_in_the_dark(found: Refined) -> float:
    """Mean square of what is left of the histograms of codes and of what stands between measured
    samples, in standard errors, over all darks and channels together; 0 without darks.
    """
    dark = [z for (_, lit), several in _of_codes(found).items() if not lit for z in several]
    return float(np.mean(np.square(dark))) if dark else 0.0


def _of_codes(found: Refined) -> dict[tuple[str, bool], list[float]]:
    """What is left of these figures, by channel and whether a shot is lit."""
    keys = found.space.keys
    left: dict[tuple[str, bool], list[float]] = defaultdict(list)
    for key, z in zip(keys, found.gap[: len(keys)], strict=True):
        if key.family in ("codes", INTERPOLATION):
            left[key.lattice[0], key.shot in found.lit].append(float(z))
    return left


def finer(base: Base, scenery: Scenery) -> Iterator[Base]:
    """Cameras like this one that have more bits until the last rounding and nothing in between, one
    for each such way of counting; none of a camera that is known to count in another way.
    """
    # how wide even codes are is told where it can be
    if base.arithmetic != IN_FRACTIONS or base.white_balance is not None:
        return
    # without a demosaicer halves up move all codes alike
    for rule in FINER if scenery.body.fills_in else (OF_64THS,):
        yield by_rule(base, rule)
