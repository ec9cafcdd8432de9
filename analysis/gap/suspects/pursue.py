"""Follow one suspect: its strength, its shape, and the base along with them, by twins."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from analysis.gap.calibrate.fit import FINAL_SEEDS
from analysis.gap.calibrate.turning import turn
from analysis.gap.camera.base import Base
from analysis.gap.camera.handles import free_parameters, step_from
from analysis.gap.measure.case import Candidate, Case, candidate, vector
from analysis.gap.measure.signature import (
    Evidence,
    Signature,
    response_of,
    scaled,
    signature,
    signed,
)
from analysis.gap.suspects.adapt import USUAL_RESPONSE
from analysis.gap.suspects.beginnings import is_a_scale, otherwise
from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect, Parameter

STRENGTH_ROUNDS = 2
"""How often a strength is looked for again by the signature at the last one."""

CLOSE = 0.03
"""From 1, by which the amount of a signature may differ where its strength is right."""

SHAPE_ROUNDS = 3
"""Times that the parameters of a suspect take a step together, at most."""

WORTH_A_SHAPE = 6.0
"""Fall of chi-squared from which another shape, colour or choice of a suspect is kept."""

CHOOSE_AGAIN_MISFIT = 1.05
"""Misfit (chi-squared over the expected one) beyond which a choice is made differently as well."""

SHAPED = 0.02
"""Part of chi-squared that a round of shaping must take off."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Try:
    """An effect and a base fitted together, and what they leave of the capture."""

    effect: Effect
    shown: Signature
    chi2: float

    @property
    def base(self) -> Base:
        """The camera, with the levels that the effect leaves to it."""
        return self.shown.base


def pursue(case: Case, found: Evidence) -> Candidate:
    """The strength, then the shape, then the strength again, the base along with them."""
    turned, space = case.fitting.turned, case.fitting.turned.space

    def if_possible(effect: Effect, base: Base) -> _Try | None:
        shown = signature(effect, case.known, base=base, seeds=FINAL_SEEDS)
        if shown is None:
            return None
        left = turned.left(case.fit_gap - vector(space, shown))
        return _Try(effect=effect, shown=shown, chi2=float(left @ left))

    def attempt(effect: Effect, base: Base) -> _Try:
        tried = if_possible(effect, base)
        assert tried is not None, "the suspect has been simulated before"
        return tried

    response = USUAL_RESPONSE

    def strengthened(start: _Try) -> _Try:
        """The strength by its own signature, again and again."""
        nonlocal response
        best = now = start
        tried = [(1.0, _amount(case, now.shown))]
        for _ in range(STRENGTH_ROUNDS):
            amount = tried[-1][1]
            if amount <= 0 or (abs(amount - 1) < CLOSE and len(tried) > 1):
                break
            factor = tried[-1][0] * float(np.clip(amount ** (1 / response), 0.2, 5.0))
            effect = scaled(start.effect, factor)
            # what the base has moved already is in the vector
            left = turned.amounts(case.fit_gap - amount * vector(space, now.shown))
            now = attempt(effect, turn(now.base, case.known.ways, left))
            tried.append((factor, _amount(case, now.shown)))
            response = response_of(tried, response)
            best = min(best, now, key=lambda one: one.chi2)
        return best

    best = strengthened(_numbered(attempt, attempt(found.effect, case.known.base)))
    best = _coloured(case, _balanced(case, best, response, attempt), attempt)
    for _ in range(SHAPE_ROUNDS):
        free = free_parameters(best.effect)
        if not free:
            break
        shaped = _reshaped(case, best, free, attempt)
        if shaped.chi2 > best.chi2 - max(WORTH_A_SHAPE, SHAPED * best.chi2):
            break
        best = strengthened(shaped)
    while best.chi2 > CHOOSE_AGAIN_MISFIT * case.fitting.spread.expected.sum():
        others = [if_possible(one, best.base) for one in otherwise(best.effect)]
        stronger = [strengthened(one) for one in others if one is not None]
        other = min(stronger, key=lambda one: one.chi2, default=best)
        gained, least = best.chi2 - other.chi2, SHAPED * best.chi2
        if gained <= WORTH_A_SHAPE:
            break
        best = other
        if gained <= least:
            break
    return candidate(case, best.shown, found.absorbed)


def _numbered(attempt: Callable[[Effect, Base], _Try], now: _Try) -> _Try:
    """Climb along a parameter that is a long range of whole numbers, by halving steps."""
    for p in now.effect.parameters():
        if not is_a_scale(p):
            continue
        step = 6.0
        while step >= 1.0:
            better = now
            for by in (-step, step):
                value = p.clipped(getattr(now.effect, p.name) + by)
                tried = attempt(
                    dataclasses.replace(now.effect, **{p.name: float(round(value))}), now.base
                )
                better = min(better, tried, key=lambda one: one.chi2)
            step = step / 2 if better is now else step
            now = better
    return now


def _balanced(
    case: Case, now: _Try, response: float, attempt: Callable[[Effect, Base], _Try]
) -> _Try:
    """The strengths of an effect that has several, each by its own signature."""
    active = [p for p in free_parameters(now.effect) if p.identity is not None]
    if len(active) < 2:
        return now
    turned, space = case.fitting.turned, case.fitting.turned.space
    columns = []
    for p in active:
        alone = {q.name: q.identity for q in active if q.name != p.name}
        shown = attempt(dataclasses.replace(now.effect, **alone), now.base).shown
        columns.append(turned.left(vector(space, shown)))
    matrix = np.array(columns).T
    if np.linalg.norm(matrix, axis=0).min() < WORTH_A_SHAPE**0.5:
        return now  # one is nothing without the other
    least = 0.05 if not signed(type(now.effect)) else -4.0
    amounts = lsq_linear(matrix, case.fit_left, bounds=(least, 16.0)).x
    values = {}
    for p, amount in zip(active, amounts, strict=True):
        factor = float(np.sign(amount) * abs(amount) ** (1 / response))
        identity = p.identity or 0.0
        away = factor * (getattr(now.effect, p.name) - identity)
        values[p.name] = _within(p, away)
    return min(now, attempt(dataclasses.replace(now.effect, **values), now.base),
               key=lambda one: one.chi2)  # fmt: skip


def _coloured(case: Case, now: _Try, attempt: Callable[[Effect, Base], _Try]) -> _Try:
    """A strength that may differ by colour, each by its own signature."""
    turned, space = case.fitting.turned, case.fitting.turned.space
    for p in now.effect.parameters():
        value, identity = getattr(now.effect, p.name), p.identity
        if not p.per_colour or identity is None or len(case.known.base.channels) == 1:
            continue
        away = max((v - identity for v in Colours.of(value)), key=abs)
        if away == 0:
            continue

        alone = [Colours(**{c: float(c == only) for c in CHANNELS}) for only in CHANNELS]
        shown = [attempt(_by_colour(now.effect, p, away, one), now.base).shown for one in alone]
        matrix = turned.left(np.array([vector(space, one) for one in shown])).T
        least = -4.0 if signed(type(now.effect)) else 0.0
        amounts = lsq_linear(matrix, case.fit_left, bounds=(least, 16.0)).x
        parts = Colours(**dict(zip(CHANNELS, map(float, amounts), strict=True)))
        better = attempt(_by_colour(now.effect, p, away, parts), now.base)
        if better.chi2 < now.chi2 - max(WORTH_A_SHAPE, SHAPED * now.chi2):
            now = better
    return now


def _by_colour(effect: Effect, p: Parameter, away: float, parts: Colours) -> Effect:
    """An effect with a strength that is some part of one value in each colour."""
    values = parts.map(lambda part: _within(p, away * part))
    return dataclasses.replace(effect, **{p.name: values})


def _within(p: Parameter, away: float) -> float:
    """The value that is so far from where the effect vanishes, inside the range."""
    return p.clipped((p.identity or 0.0) + away)


def _reshaped(
    case: Case,
    now: _Try,
    free: list[Parameter],
    attempt: Callable[[Effect, Base], _Try],
) -> _Try:
    """One Gauss-Newton step of all parameters of an effect."""
    turned, space = case.fitting.turned, case.fitting.turned.space
    current = vector(space, now.shown)
    steps = np.array(
        [
            step_from(getattr(now.effect, p.name), p, 3.0 if p.identity is None else 1.0)
            for p in free
        ]
    )
    columns = []
    for p, by in zip(free, steps, strict=True):
        moved = dataclasses.replace(now.effect, **{p.name: getattr(now.effect, p.name) + float(by)})
        columns.append((vector(space, attempt(moved, now.base).shown) - current) / by)
    matrix = turned.left(np.array(columns))
    # a parameter that hardly shows stays near where it is
    widths = 2.0 * np.abs(steps)
    square = matrix @ matrix.T + np.diag(1.0 / widths**2)
    amounts = np.linalg.solve(square, matrix @ turned.left(case.fit_gap - current))
    values = {
        p.name: p.clipped(getattr(now.effect, p.name) + by)
        for p, by in zip(free, np.clip(amounts, -widths, widths), strict=True)
    }
    return attempt(dataclasses.replace(now.effect, **values), now.base)


def _amount(case: Case, shown: Signature) -> float:
    """How many times a signature is in the frames that fit."""
    direction = case.fitting.turned.left(vector(case.fitting.turned.space, shown))
    norm = float(direction @ direction)
    return float(direction @ case.fit_left) / norm if norm > 0 else 0.0
