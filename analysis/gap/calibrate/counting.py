"""How a camera counts between its converter and what leaves it, told by which twins fit.

Codes of one value in 17 sixteenths and of the next in 15, or red and blue multiplied by a white
balance before their last four bits go: this belongs to a camera of 12 bits that gives 8 and is no
fault of its converter, though codes are not equally wide.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.refine import FAR, Refined, refine, refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.arithmetic import (
    FINER,
    IN_FRACTIONS,
    OF_64THS,
    OF_SIXTEENTHS_UP,
    TO_EVEN,
    UP,
    WIDE,
)
from analysis.gap.look.families import INTERPOLATION
from analysis.gap.look.finer_gains import NEAR_BLACK, QUARTERS, finer_gain
from analysis.gap.look.observation import Observation
from sensor.effects.white_balance import WhiteBalance
from sensor.interpolation import COUNTING

Floats = NDArray[np.float64]

UNEVEN = 3.5
"""Mean square of what is left of the histograms, in standard errors, that is no chance: of seven
figures it is one in a thousand times."""

MOST_GAIN = 4.0
"""Of a white balance; what looks like more is none."""

GAIN_ERROR = 0.01
"""Standard deviation of a gain in parts of it, as photon transfer tells it."""

LIKELIEST = 2
"""Ways of counting in finer codes that are calibrated: their black levels differ a little."""

EVENER = 0.5
"""Part of the unevenness that finer codes leave where they are its cause."""

A_LITTLE = 0.1
"""Part of the variance of fixed offsets."""

NO_WORSE = 1.1
"""Times chi-squared that they may leave of all figures: their twins are others."""


def counted(found: Refined, seen: Observation, scenery: Scenery, enough: float = FAR) -> Base:
    """The base with the arithmetic of its demosaicer that fits best; the same where it fits.

    Processing behind a demosaicer that counts in whole numbers hides from `arithmetic_of` that it
    does.

    Args:
        found: a camera against the frames.
        seen: the frames that fit.
        scenery: their light and shots.
        enough: misfit from which others are tried.
    """
    if found.misfit < enough:
        return found.base
    others = (
        refined(by_rule(found.base, rule), seen, scenery, found.effects)
        for rule in scenery.rules
        if rule != found.base.arithmetic
    )
    return min([found, *others], key=lambda one: one.chi2).base


def by_rule(base: Base, rule: int) -> Base:
    """The camera with another way of counting, and codes that are as high in the mean."""
    raised = UP.get(rule, 0.0) - UP.get(base.arithmetic, 0.0)
    return dataclasses.replace(base, arithmetic=rule, black_dn=base.black_dn - raised)


def in_finer_codes(
    found: Refined, seen: Observation, scenery: Scenery, counts: Mapping[str, Floats]
) -> Refined:
    """The camera with a converter of more bits than leave it, where that is why codes are uneven.

    Args:
        found: a calibrated camera.
        seen: the frames that fit.
        scenery: their light and shots.
        counts: histograms of lit shots, by channel.
    """
    if unevenness(found) < UNEVEN:
        return found
    # where more than the histograms is wrong, whatever makes them uneven as well may be the cause,
    # unless codes tell of finer ones by themselves
    told = found.misfit <= FAR or found.base.arithmetic in WIDE

    def likeliest(bases: Iterable[Base]) -> list[Refined]:
        against = (refined(reopened(base, scenery), seen, scenery, found.effects) for base in bases)
        return sorted(against, key=unevenness)[:LIKELIEST]

    # far from their black level the codes of darks say little of gains that a comb tells
    likely = [
        *likeliest(finer(found.base, scenery) if told else ()),
        *likeliest(by_combs(found.base, scenery, counts)),
    ]
    tried = [refine(one.base, seen, scenery, found.effects) for one in likely]
    best = min([found, *likely, *tried], key=unevenness)
    if best.base.gain_error:
        again = refine(balanced(best.base), seen, scenery, found.effects)
        best = min(best, again, key=unevenness)
    was, left = unevenness(found), unevenness(best)
    halved = left < EVENER * was and best.chi2 < NO_WORSE * found.chi2
    none_left = left < UNEVEN and best.chi2 < found.chi2
    return best if halved or none_left else found


def balanced(base: Base) -> Base:
    """The same camera whose white balance has all that its channels' gains differ by: its converter
    is the same for all colours.

    Args:
        base: with or without a white balance.
    """
    red, _, blue = map(float, base.gain_dn_per_e / base.gain_dn_per_e[1])
    return base.multiplied(WhiteBalance(red_gain=red, blue_gain=blue))


def reopened(base: Base, scenery: Scenery) -> Base:
    """The camera whose dark currents may differ between photosites: by codes of another width they
    seem not to, and what is 0 is no knob.
    """
    exposures = {shot.exposure_s for shot in scenery.shots}
    if base.dark_spread2 > 0 or len(exposures) < 2:
        return base
    offsets_e2 = float(np.mean(base.fpn_dn2 / np.square(base.gain_dn_per_e)))
    return dataclasses.replace(base, dark_spread2=A_LITTLE * offsets_e2 / max(exposures) ** 2)


def by_combs(base: Base, scenery: Scenery, counts: Mapping[str, Floats]) -> Iterator[Base]:
    """The same camera with quarters of a code behind its converter, times gains that combs tell.

    Args:
        base: calibrated in whole codes.
        scenery: its light and shots.
        counts: histograms of lit shots, by channel.
    """
    if not _multiplies(base, scenery):
        return
    relative = base.gain_dn_per_e / base.gain_dn_per_e[1]
    black_dn = float(base.black_dn[1])
    rules = [rule for rule in _finer_rules(base) if COUNTING[rule].steps == QUARTERS]
    for about_black, origins_dn in ((1.0, black_dn + NEAR_BLACK), (0.0, np.zeros(1))):
        red = finer_gain(counts["R"], QUARTERS, float(relative[0]), black_dn, origins_dn)
        blue = finer_gain(counts["B"], QUARTERS, float(relative[2]), black_dn, origins_dn)
        if red is None or blue is None:
            continue
        gains = WhiteBalance(red_gain=red, blue_gain=blue, about_black=about_black)
        for rule in rules:
            yield by_rule(base.multiplied(gains), rule)


def unevenness(found: Refined) -> float:
    """Mean square of what is left of the histograms of codes and of what stands between measured
    samples, in standard errors: of that channel, in the dark or in the light, of which it is most.
    Gains make combs in red and in blue alone, and few codes of a dark show more of them than many
    lit ones, whose combs are averaged.
    """
    keys = found.space.keys
    left: dict[tuple[str, bool], list[float]] = defaultdict(list)
    for key, z in zip(keys, found.gap[: len(keys)], strict=True):
        if key.family in ("codes", INTERPOLATION):
            left[key.lattice[0], key.shot in found.lit].append(float(z))
    return max((float(np.mean(np.square(z))) for z in left.values()), default=0.0)


def finer(base: Base, scenery: Scenery) -> Iterator[Base]:
    """The same camera with more bits until the last rounding; with and without gains there."""
    if scenery.body.pixels != "rgb8":
        # halves up move all codes alike, and nobody multiplies a mosaic
        if base.arithmetic == IN_FRACTIONS:
            yield by_rule(base, OF_64THS)
        return
    rules = _finer_rules(base)
    for rule in rules:
        if rule not in (base.arithmetic, OF_SIXTEENTHS_UP):
            yield by_rule(base, rule)
    if not _multiplies(base, scenery):
        return
    red, _, blue = map(float, base.gain_dn_per_e / base.gain_dn_per_e[1])
    for about_black in (1.0, 0.0):
        gains = WhiteBalance(red_gain=red, blue_gain=blue, about_black=about_black)
        for rule in rules:
            multiplied = dataclasses.replace(base.multiplied(gains), gain_error=GAIN_ERROR)
            yield by_rule(multiplied, rule)


def _finer_rules(base: Base) -> tuple[int, ...]:
    """Ways of counting in finer codes that a camera may have."""
    if base.arithmetic not in (IN_FRACTIONS, *TO_EVEN) or base.white_balance is not None:
        return ()
    # how wide even codes are is told where it can be
    return FINER if base.arithmetic == IN_FRACTIONS else (base.arithmetic,)


def _multiplies(base: Base, scenery: Scenery) -> bool:
    """Whether colours may differ by gains behind a converter that is the same for all of them."""
    if scenery.body.pixels != "rgb8" or base.white_balance is not None:
        return False
    relative = base.gain_dn_per_e / base.gain_dn_per_e[1]
    return bool(np.all((relative > 1 / MOST_GAIN) & (relative < MOST_GAIN)))
