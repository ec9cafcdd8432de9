"""Where to begin with a suspect: other cameras from which no small step leads to the right one, and
other choices of the effect."""

from __future__ import annotations

import dataclasses
from itertools import product

import numpy as np

from analysis.gap.calibrate.fit import together
from analysis.gap.calibrate.refine import Refined
from analysis.gap.camera.base import Base
from analysis.gap.look.arithmetic import IN_FRACTIONS
from analysis.gap.look.observation import Observation
from analysis.gap.measure.signature import beginnings_of, starts, strengths
from analysis.gap.ready.hints import Hints
from sensor.effect import Effect, Parameter

LONG = 10
"""Whole numbers beyond this many are a scale, not a choice."""

LOUDER = 4.0
"""Times the variance of the read noise: what a codec leaves of twice the noise is not seen."""


def uncoded(base: Base) -> Base:
    """The base with twice the read noise and in focus, of a camera that counts in fractions: what a
    codec takes away of both no small step gives back.
    """
    return dataclasses.replace(
        base, read_dn2=LOUDER * base.read_dn2, blur_px2=0.0, arithmetic=IN_FRACTIONS
    )


def as_dark(found: Refined, seen: Observation) -> Base:
    """The base with darks as bright as the frames, and with the noise of what gathers in them.

    What rounds codes takes their mean away, or adds to it, and makes them scatter by steps of its
    own. A camera that is calibrated without it has a black level that is off by half a step, and a
    dark current whose noise is that of the steps, not of what darks are brighter by.

    Args:
        found: the camera with the effect, before either is mended.
        seen: the frames that fit.
    """
    bodies = together(found.bodies.values())
    dark = [place for place, label in enumerate(bodies.shots) if label not in found.lit]
    missing = seen.means.mean(axis=0) - bodies.means.mean(axis=0)
    base = found.base
    return dataclasses.replace(
        base,
        black_dn=base.black_dn + missing[dark].mean(axis=(0, 2)),
        dark_e_per_s=max(base.shown_e_per_s, 0.0),
    )


def every_choice(effect: Effect, told: Hints | None = None) -> list[Effect]:
    """An effect as it is, then with all its choices made in all ways.

    Args:
        effect: the effect.
        told: what the frames tell of it, if they do. What they tell is no choice, and all others
            are then, those included that no search begins with.
    """
    chosen = [p for p in effect.parameters() if _is_a_choice(p)]
    if told:
        ranges = [
            [getattr(effect, p.name)]
            if p.name in told
            else [float(v) for v in np.arange(p.minimum, p.maximum + 1)]
            for p in chosen
        ]
        ways = [dict(zip((p.name for p in chosen), w, strict=True)) for w in product(*ranges)]
    else:
        ways = [{p.name: getattr(one, p.name) for p in chosen} for one in starts(type(effect))]
    return list(dict.fromkeys([effect, *(dataclasses.replace(effect, **way) for way in ways)]))


ELSEWHERE = 3.0
"""Times a parameter from which another value of it is another place to begin."""


def choices(effect: Effect) -> list[Effect]:
    """Effects like this one, each with a choice made differently, with another of its strengths, or
    with a parameter as far from here as its search begins elsewhere.
    """
    return [*otherwise(effect), *of_other_strengths(effect)]


def otherwise(effect: Effect) -> list[Effect]:
    """Effects like this one, each with a choice made differently, or with a parameter as far from
    here as its search begins elsewhere.
    """
    return [*chosen_otherwise(effect), *_elsewhere(effect)]


def choice_of(effect: Effect) -> tuple[float, ...]:
    """The choices that an effect was made with."""
    return tuple(getattr(effect, p.name) for p in effect.parameters() if _is_a_choice(p))


def kind_of(effect: Effect) -> tuple[tuple[float, ...], frozenset[str]]:
    """The choices that an effect was made with, and which of its strengths it has: a converter that
    weighs is not one that compares.
    """
    return choice_of(effect), _strengths_on(effect)


def is_a_scale(p: Parameter) -> bool:
    """Whether a parameter is one of many whole numbers, along which a search climbs."""
    return p.whole and p.maximum - p.minimum >= LONG


def _is_a_choice(p: Parameter) -> bool:
    return p.whole and not is_a_scale(p)


def chosen_otherwise(effect: Effect) -> list[Effect]:
    """Effects like this one, each with one of its choices as another search for it begins, or made
    one next to it: of many a search begins with a few.
    """
    return [
        dataclasses.replace(effect, **{p.name: value})
        for p in effect.parameters()
        if _is_a_choice(p)
        for value in sorted({*beginnings_of(p), *_next_to(p, getattr(effect, p.name))})
        if value != getattr(effect, p.name)
    ]


def _next_to(p: Parameter, value: float) -> set[float]:
    """The choices one below and one above, where the effect does not vanish."""
    return {p.clipped(value - 1), p.clipped(value + 1)} - {p.identity}


def of_other_strengths(effect: Effect) -> list[Effect]:
    """Effects of this kind as searches begin, with others of its strengths on, or more of them."""
    others = {_strengths_on(one): one for one in reversed(starts(type(effect)))}
    return [one for on, one in others.items() if on != _strengths_on(effect)]


def with_more_strengths(effect: Effect) -> list[Effect]:
    """Effects like this one, each with one strength on that is off here, as searches begin."""
    off = {p.name for p in strengths(type(effect)) if not p.whole} - _strengths_on(effect)
    return list(
        dict.fromkeys(
            dataclasses.replace(effect, **{name: getattr(one, name)})
            for one in starts(type(effect))
            for name in sorted(off & _strengths_on(one))
        )
    )


def _elsewhere(effect: Effect) -> list[Effect]:
    return [
        dataclasses.replace(effect, **{p.name: value})
        for p in effect.parameters()
        if not p.whole and isinstance(now := getattr(effect, p.name), float)
        for value in p.starts
        if now > 0 and value > 0 and max(now / value, value / now) > ELSEWHERE
    ]


def _strengths_on(effect: Effect) -> frozenset[str]:
    """Names of the strengths that are not where the effect vanishes."""
    return frozenset(
        p.name
        for p in strengths(type(effect))
        if not p.whole and getattr(effect, p.name) != p.identity
    )
