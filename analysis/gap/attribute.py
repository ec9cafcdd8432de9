"""Which effect: every suspect at the strength that fits, scored on frames that took no part."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from analysis.gap.base import Base
from analysis.gap.distance import Yardstick
from analysis.gap.fit import SEEDS, Fit, refine, turn
from analysis.gap.hints import Hints
from analysis.gap.nuisance import free_parameters, step_of
from analysis.gap.observe import Observation
from analysis.gap.space import Space
from analysis.gap.suspects import (
    Evidence,
    Signature,
    hold,
    scaled,
    signature,
    signed,
    starts,
    strengths,
)
from analysis.gap.twin import twin
from sensor.effect import Effect, Parameter

Floats = NDArray[np.float64]

ROUNDS = 2
"""How often a suspect is simulated again at the strength that it seems to have."""

RIGHT = (0.75, 1.33)
"""An amount in this range needs no further round."""

ADAPTED = 7
FINALISTS = 3
NEAR = 0.2
"""A suspect with less than this part of the best score is no finalist."""

WORTH_A_LOOK = 6.0
"""A suspect that takes less off chi-squared is not followed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A capture against a model, in two halves of its frames.

    Attributes:
        known: the model, calibrated.
        fitting, scoring: spaces of the frames that fit and of those that score.
        fit_seen: what was seen of the frames that fit.
        fit_gap: the capture's difference from the model, in the space of the frames that fit.
        fit_left, score_left: what calibration leaves of it in each space.
        groups: groups of frames in each half.
    """

    known: Fit
    fitting: Yardstick
    scoring: Yardstick
    fit_seen: Observation
    fit_gap: Floats
    fit_left: Floats
    score_left: Floats
    groups: tuple[int, int]


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """A suspect at its fitted strength.

    Attributes:
        effect: with fitted parameters.
        errors: their standard errors, where a parameter was fitted.
        score: fall of chi-squared on frames that took no part, both ways added.
        fit_score: the same on the frames that fit.
        forward: fall of chi-squared on the scoring frames alone, at the strength that was fitted.
        absorbed: part of the signature that calibration takes up.
        base: the camera, calibrated together with the effect.
        shown: its signature.
        amount: part of the signature that the capture has; 1 where the strength was fitted.
    """

    effect: Effect
    errors: dict[str, float]
    score: float
    fit_score: float
    forward: float
    absorbed: float
    base: Base
    shown: Signature
    amount: float

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


def attribute(
    case: Case,
    kinds: Iterable[type[Effect]],
    hints: Hints,
    watch: Callable[[str], None] = lambda name: None,
) -> list[Candidate]:
    """Every suspect that these frames may show, best first."""
    references = {seed: _reference(case, seed) for seed in SEEDS}
    first: list[Evidence] = []
    for kind in kinds:
        watch(kind.name)
        best = _best_start(case, kind, hints, references)
        if best is not None:
            first.append(best)
    first.sort(key=lambda e: -e.score)
    adapted = []
    for found in first[:ADAPTED]:
        if found.score > WORTH_A_LOOK:
            watch(found.name)
            adapted.append(_adapt(case, found, references))
    adapted.sort(key=lambda e: -e.score)
    finalists = [e for e in adapted if e.score > NEAR * adapted[0].score][:FINALISTS]
    many = references
    if finalists:
        many = {
            seed: references[seed] if seed in references else _reference(case, seed)
            for seed in FINAL_SEEDS
        }
    candidates = []
    for found in finalists:
        watch(found.name)
        candidates.append(_refine(case, found, many))
    done = {c.name for c in candidates}
    candidates += [_as_it_is(case, e) for e in [*adapted, *first] if e.name not in done]
    unique = {c.name: c for c in reversed(candidates)}
    return sorted(unique.values(), key=lambda c: -c.score)


def _reference(case: Case, seed: int) -> Observation:
    known = case.known
    return known.textured(twin(known.scenery, known.base, effects=known.effects, seed=seed))


def _best_start(
    case: Case, kind: type[Effect], hints: Hints, references: dict[int, Observation]
) -> Evidence | None:
    """The start of a suspect's search that fits best; None where these frames cannot have it."""
    best: Evidence | None = None
    for effect in starts(kind):
        hinted = {p.name: hints[p.name] for p in kind.parameters() if p.name in hints}
        if hinted:
            effect = dataclasses.replace(effect, **hinted)
        found = _held(case, effect, references)
        if found is not None and (best is None or found.score > best.score):
            best = found
    return best


def _held(
    case: Case,
    effect: Effect,
    references: dict[int, Observation],
) -> Evidence | None:
    shown = signature(effect, case.known, others=case.known.effects, references=references)
    if shown is None:
        return None
    return hold(shown, case.fitting.turned, case.fit_left)


def _adapt(case: Case, found: Evidence, references: dict[int, Observation]) -> Evidence:
    """Simulate at the strength it seems to have, until it has it."""
    best = found
    factor, response = 1.0, 1.5
    tried: list[tuple[float, float]] = [(1.0, found.amount)]
    for _ in range(ROUNDS):
        amount = tried[-1][1]
        if RIGHT[0] <= amount <= RIGHT[1] or amount == 0.0:
            break
        if amount < 0:
            factor = -factor * min(abs(amount), 4.0)
        else:
            factor *= float(np.clip(amount ** (1.0 / response), 0.1, 8.0))
        shown = _held(case, scaled(found.effect, factor), references)
        if shown is None or shown.effect == best.effect:
            break
        tried.append((factor, shown.amount))
        response = _response(tried, response)
        if shown.score > best.score or not RIGHT[0] <= best.amount <= RIGHT[1]:
            best = shown
    return best


def _response(tried: Sequence[tuple[float, float]], before: float) -> float:
    """Power of the strength with which a signature grows, from the last two tries."""
    (f1, a1), (f2, a2) = tried[-2:]
    if min(f1 * f2, a1, a2) <= 0 or abs(np.log(f2 / f1)) < 0.3:
        return before  # too near each other to tell
    # the signature at f2 is a1 / a2 times that at f1
    return float(np.clip(np.log(a1 / a2) / np.log(f2 / f1), 0.8, 2.5))


def _shapes(effect: Effect) -> list[Parameter]:
    """Parameters that are fitted besides the strength as a whole, where an effect has several."""
    free = free_parameters(effect)
    return free if len(free) > 1 else []


FINAL_SEEDS = tuple(range(SEEDS[0], SEEDS[0] + 3))
"""Random numbers with which finalists are simulated: their noise is then below that of frames."""

SHAPE_ROUNDS = 1
STRENGTH_ROUNDS = 2
CLOSE = 0.03
WORTH_A_SHAPE = 6.0


@dataclass(frozen=True, kw_only=True, eq=False)
class _Try:
    """An effect and a base fitted together, and what they leave of the capture."""

    effect: Effect
    base: Base
    shown: Signature
    chi2: float


def _refine(case: Case, found: Evidence, many: dict[int, Observation]) -> Candidate:
    """The strength, then the shape, then the strength again, the base along with them."""
    turned, space = case.fitting.turned, case.fitting.turned.space

    def attempt(effect: Effect, base: Base) -> _Try:
        shown = signature(
            effect,
            case.known,
            others=case.known.effects,
            base=base,
            seeds=FINAL_SEEDS,
            references=many,
        )
        assert shown is not None, "the suspect has been simulated before"
        left = turned.left(case.fit_gap - _vector(space, shown))
        return _Try(effect=effect, base=base, shown=shown, chi2=float(left @ left))

    response = 1.5

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
            vector = _vector(space, now.shown)
            # what the base has moved already is in the vector
            left = turned.amounts(case.fit_gap - amount * vector)
            now = attempt(effect, turn(now.base, case.known.ways, left))
            tried.append((factor, _amount(case, now.shown)))
            response = _response(tried, response)
            best = min(best, now, key=lambda one: one.chi2)
        return best

    best = strengthened(_numbered(attempt, attempt(found.effect, case.known.base)))
    best = _balanced(case, best, response, attempt)
    errors: dict[str, float] = {}
    for _ in range(SHAPE_ROUNDS):
        shapes = _shapes(best.effect)
        if not shapes:
            break
        shaped, errors = _reshaped(case, best, shapes, attempt)
        if shaped.chi2 < best.chi2 - WORTH_A_SHAPE:
            best = strengthened(shaped)
    if best.chi2 > MISFIT * float(case.fitting.expected.sum()):
        # the base has come far from where its directions were read: it is calibrated anew
        effects = (*case.known.effects, best.effect)
        base = refine(best.base, case.fit_seen, case.known.scenery, effects, steps=2)
        best = min(best, strengthened(attempt(best.effect, base)), key=lambda one: one.chi2)
    return _candidate(case, best, errors, found.absorbed, response)


MISFIT = 1.3
"""Part of the expected chi-squared beyond which a fit is gone over once more."""

LONG = 10
"""Whole numbers beyond this many are a scale, not a choice."""


def _numbered(attempt: Callable[[Effect, Base], _Try], now: _Try) -> _Try:
    """Climb along a parameter that is a long range of whole numbers, by halving steps."""
    for p in now.effect.parameters():
        if not p.whole or p.maximum - p.minimum < LONG:
            continue
        step = 6.0
        while step >= 1.0:
            better = now
            for by in (-step, step):
                value = float(np.clip(getattr(now.effect, p.name) + by, p.minimum, p.maximum))
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
        columns.append(turned.left(_vector(space, shown)))
    matrix = np.array(columns).T
    if np.linalg.norm(matrix, axis=0).min() < WORTH_A_SHAPE**0.5:
        return now  # one is nothing without the other
    least = 0.05 if not signed(type(now.effect)) else -4.0
    amounts = lsq_linear(matrix, case.fit_left, bounds=(least, 16.0)).x
    values = {}
    for p, amount in zip(active, amounts, strict=True):
        factor = float(np.sign(amount) * abs(amount) ** (1 / response))
        identity = p.identity or 0.0
        moved = identity + factor * (getattr(now.effect, p.name) - identity)
        values[p.name] = float(np.clip(moved, p.minimum, p.maximum))
    return min(now, attempt(dataclasses.replace(now.effect, **values), now.base),
               key=lambda one: one.chi2)  # fmt: skip


def _reshaped(
    case: Case,
    now: _Try,
    shapes: list[Parameter],
    attempt: Callable[[Effect, Base], _Try],
) -> tuple[_Try, dict[str, float]]:
    """One Gauss-Newton step of all parameters of an effect."""
    turned, space = case.fitting.turned, case.fitting.turned.space
    current = _vector(space, now.shown)
    steps = np.array(
        [(3.0 if p.identity is None else 1.0) * step_of(now.effect, p) for p in shapes]
    )
    columns = []
    for p, by in zip(shapes, steps, strict=True):
        moved = dataclasses.replace(now.effect, **{p.name: getattr(now.effect, p.name) + float(by)})
        columns.append((_vector(space, attempt(moved, now.base).shown) - current) / by)
    matrix = turned.left(np.array(columns))
    # a parameter that hardly shows stays near where it is
    widths = 2.0 * np.abs(steps)
    square = matrix @ matrix.T + np.diag(1.0 / widths**2)
    by_least_squares = np.linalg.solve(square, matrix @ turned.left(case.fit_gap - current))
    values = {
        p.name: float(np.clip(getattr(now.effect, p.name) + by, p.minimum, p.maximum))
        for p, by in zip(shapes, np.clip(by_least_squares, -widths, widths), strict=True)
    }
    errors = np.sqrt(np.diag(np.linalg.inv(square)))
    return (
        attempt(dataclasses.replace(now.effect, **values), now.base),
        {p.name: float(e) for p, e in zip(shapes, errors, strict=True)},
    )


def _amount(case: Case, shown: Signature) -> float:
    """How many times a signature is in the frames that fit."""
    direction = case.fitting.turned.left(_vector(case.fitting.turned.space, shown))
    norm = float(direction @ direction)
    return float(direction @ case.fit_left) / norm if norm > 0 else 0.0


def _vector(space: Space, shown: Signature) -> Floats:
    return space.vector(shown.figures, shown.means)


def _as_it_is(case: Case, found: Evidence) -> Candidate:
    """A suspect that was not followed, at the amount that least squares gives it."""
    tried = _Try(effect=found.effect, base=case.known.base, shown=found.signature, chi2=0.0)
    return _candidate(case, tried, {}, found.absorbed, 1.0, found.amount)


def _candidate(
    case: Case,
    tried: _Try,
    errors: dict[str, float],
    absorbed: float,
    response: float,
    amount: float = 1.0,
) -> Candidate:
    """Score a fitted suspect on both halves: fitted on one, scored on the other.

    The figures that are stated come from both halves together.
    """
    shown = tried.shown
    fitted = amount * case.fitting.turned.left(_vector(case.fitting.turned.space, shown))
    scored = amount * case.scoring.turned.left(_vector(case.scoring.turned.space, shown))
    forward = _gain(case.score_left, scored)
    norm = float(scored @ scored)
    back = float(scored @ case.score_left) / norm if norm > 0 else 0.0
    spread = _spread(case.scoring, scored)
    share, error = _both_halves(case, shown, fitted, back, spread)
    effect = tried.effect
    if amount == 1.0 and norm > 0:
        effect = scaled(effect, float(np.clip(share, 0.25, 4.0)) ** (1 / response))
        errors = {p.name: errors.get(p.name, 0.0) for p in strengths(type(effect))} | errors
        for p in strengths(type(effect)):
            value = getattr(effect, p.name)
            if isinstance(value, float) and not p.whole and p.identity is not None:
                own = abs(value - p.identity) * error / response
                errors[p.name] = float(np.hypot(errors[p.name], own))
    return Candidate(
        effect=effect,
        errors=errors,
        score=(forward + _gain(case.fit_left, back * fitted)) / spread,
        fit_score=_gain(case.fit_left, fitted) / spread,
        forward=forward,
        absorbed=absorbed,
        base=tried.base,
        shown=shown,
        amount=amount,
    )


def _both_halves(
    case: Case, shown: Signature, fitted: Floats, back: float, spread: float
) -> tuple[float, float]:
    """Amount of a signature in all frames, and its relative standard error.

    The error has three parts: noise of the frames along the signature; what the effect itself does
    by chance in so many groups of frames; and the same in the twins.
    """
    norm = float(fitted @ fitted)
    if norm == 0:
        return 1.0, 1.0
    front = float(fitted @ case.fit_left) / norm
    groups = case.groups
    share = (front * groups[0] + back * groups[1]) / sum(groups)
    turned = case.fitting.turned
    count = len(turned.space.keys)
    single = np.array(
        [float(fitted[:count] @ turned.space.figures(one)) for one in shown.one_by_one]
    ) / max(float(fitted[:count] @ fitted[:count]), 1e-300)
    by_chance = float(np.var(single, ddof=1)) if len(single) > 1 else 0.0
    noise = spread / norm * groups[0] / sum(groups)
    return share, float(np.sqrt(noise + by_chance * (1 / sum(groups) + 1 / len(single))))


BORROWED = 6.0
"""Twins' worth of trust that figures have nothing in common."""


def _spread(rod: Yardstick, direction: Floats) -> float:
    """Variance of the twins along a direction; 1 where figures have nothing in common."""
    norm = float(direction @ direction)
    if norm == 0:
        return 1.0
    along = rod.residuals @ direction / np.sqrt(norm)
    count = len(along)
    return float(max(1.0, (along @ along + BORROWED) / (count + BORROWED)))


def _gain(left: Floats, explained: Floats) -> float:
    """By how much chi-squared falls."""
    return float(explained @ (2 * left - explained))
