"""Giving an effect the strength at which it has a wanted severity."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from camtruth.blind.foreign.outsider import Outsider
from camtruth.blind.ruler import Floats, Ruler, battery
from camtruth.blind.unsure import Rates
from camtruth.blind.worn import wear
from sensor.camera import Camera
from sensor.effect import Effect, Parameter
from sensor.protocol import Protocol
from sensor.record import record

TRIES = 12
NEAR = 1.25
"""A severity within this factor of the wanted one will do."""

LEAST = 1e-3
"""Severity of what does not show."""

INSIDE = 0.1
"""Part of the way, in logarithms, that a try keeps from both ends of what is left."""

LONGEST_STEP = 8.0
PROBES = (101, 202)
"""Random numbers and bodies of the two signatures, not those of the case."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Dressed:
    """A camera with an effect, at a strength that was looked for."""

    camera: Camera
    parameters: dict[str, float | dict[str, float]]
    severity: float
    absorbed: float


def own_effect(kind: type[Effect], rng: np.random.Generator) -> Effect:
    """An effect of the catalogue with its shape drawn: periods, places, kinds."""
    values: dict[str, Any] = {}
    for p in kind.parameters():
        if p.whole and p.identity is not None and p.maximum - p.minimum < 4:
            choices = [v for v in np.arange(p.minimum, p.maximum + 1) if v != p.identity]
            values[p.name] = float(rng.choice(choices))
        elif p.identity is None and p.starts and not p.whole:
            values[p.name] = float(rng.choice(p.starts))
        elif p.identity is None and not p.whole and p.default > 0 and p.unit in ("px", "s", "rows"):
            factor = float(np.exp(rng.uniform(-0.3, 0.3)))
            values[p.name] = p.clipped(p.default * factor)
    return kind(**values)


def at_strength(effect: Effect, factor: float) -> Effect:
    """An effect like this one, so many times as far from doing nothing, inside its range."""
    values = {}
    for p in effect.parameters():
        start = p.maximum if p.identity is None and p.whole else p.identity
        if start is not None:
            values[p.name] = _moved(p, start, float(getattr(effect, p.name)), factor)
    return type(effect)(**{**_plain(effect), **values})


def _plain(effect: Effect) -> dict[str, Any]:
    return {p.name: getattr(effect, p.name) for p in effect.parameters()}


def _moved(p: Parameter, start: float, value: float, factor: float) -> float:
    if factor == 1 or (p.whole and p.maximum - p.minimum < 4):
        return value  # to the last digit
    if not p.whole:
        return p.away(value, factor)
    moved = round(start + factor * (value - start))
    moved = moved - 1 if moved == start == p.maximum else moved
    moved = moved + 1 if moved == start == p.minimum else moved
    return p.clipped(moved)


class Probe:
    """Signatures of effects in one camera: what the battery shows with them, less without."""

    def __init__(self, camera: Camera, protocol: Protocol, rates: Rates, ruler: Ruler) -> None:
        self.protocol, self.rates, self.ruler = protocol, rates, ruler
        self.plain = [self._seen(camera, seed) for seed in PROBES]

    def _seen(self, camera: Camera, seed: int) -> Floats:
        body = camera.with_body(seed)
        return battery(record(body, self.protocol, self.rates, seed=seed))

    def __call__(self, camera: Camera) -> tuple[float, float]:
        """Severity and absorbed part of what the camera has more than the plain one."""
        first, second = (
            self._seen(camera, seed) - plain for seed, plain in zip(PROBES, self.plain, strict=True)
        )
        return self.ruler.severity(first, second), self.ruler.absorbed(first)


Made = tuple[Camera, dict[str, float | dict[str, float]]]
"""A camera with an effect, and the effect's parameters."""

Probing = Callable[[Camera], tuple[float, float]]
"""Severity and absorbed part of a camera's effect."""


def dressed_own(camera: Camera, effect: Effect, target: float, probe: Probing) -> Dressed:
    """A camera with an effect of the catalogue as severe as wanted, as far as its range goes."""

    def made(factor: float) -> Made:
        worn = at_strength(effect, factor)
        return camera.plus(worn), worn.values()

    return _searched(made, target, probe, 1.0, 1e-4, 1e4)


def dressed_outside(camera: Camera, outsider: Outsider, target: float, probe: Probing) -> Dressed:
    """A camera with an effect from elsewhere as severe as wanted, as far as its strengths go."""
    low, high = outsider.weakest, outsider.strongest

    def made(strength: float) -> Made:
        return wear(camera, outsider, strength), {"strength": strength}

    start = high if outsider.choice else math.sqrt(max(low, high / 1e3) * high)
    return _searched(made, target, probe, start, low, high)


def _searched(
    made: Callable[[float], Made],
    target: float,
    probe: Probing,
    start: float,
    low: float,
    high: float,
) -> Dressed:
    """Secant search in logarithms, inside of what is known to be too little and too much."""
    tried: list[tuple[float, Dressed]] = []
    at = start
    for _ in range(TRIES):
        camera, parameters = made(at)
        if any(parameters == one.parameters for _, one in tried):
            break  # a choice, or the end of the range
        severity, absorbed = probe(camera)
        found = Dressed(camera=camera, parameters=parameters, severity=severity, absorbed=absorbed)
        tried.append((at, found))
        if _off(found, target) < math.log(NEAR):
            break
        at = _between(made, tried, target, min(high, max(low, _secant(tried, target))))
    return min((found for _, found in tried), key=lambda one: _off(one, target))


def _off(found: Dressed, target: float) -> float:
    """By how much a severity is not the wanted one, as a logarithm."""
    return abs(math.log(max(found.severity, LEAST) / target))


def _secant(tried: list[tuple[float, Dressed]], target: float) -> float:
    """Where the last two tries point to; severity rises with the strength, or with its square."""
    at, found = tried[-1]
    slope = 1.0
    if len(tried) > 1:
        (a, one), (b, two) = tried[-2:]
        rise = math.log(max(two.severity, LEAST) / max(one.severity, LEAST))
        slope = min(3.0, max(0.5, rise / math.log(b / a)))
    step = float((target / max(found.severity, LEAST)) ** (1 / slope))
    return at * min(LONGEST_STEP**2, max(1 / LONGEST_STEP**2, step))


def _between(
    made: Callable[[float], Made], tried: list[tuple[float, Dressed]], target: float, at: float
) -> float:
    """A strength well inside of what was too little and what was too much, once both are known.

    What begins at a threshold has no slope on one side of it, and the end of a range is the same
    for many strengths.
    """
    little = max((a for a, one in tried if one.severity < target), default=0.0)
    much = min((a for a, one in tried if one.severity > target), default=math.inf)
    if not 0.0 < little < much < math.inf:
        return at
    if not INSIDE < math.log(at / little) / math.log(much / little) < 1 - INSIDE:
        at = math.sqrt(little * much)
    too_much = [one.parameters for a, one in tried if a == much]
    while made(at)[1] in too_much and at / little > 1 + 1e-6:
        at = math.sqrt(little * at)
    return at
