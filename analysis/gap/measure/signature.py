"""Suspects: every effect of the catalogue, as it would show in these very shots.

A suspect is simulated with the same random numbers as the base camera; the difference, less what
calibration takes up, is its signature. How much of it the capture has is least squares; then it is
simulated again at that strength, because few effects are proportional to their parameters.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.agreement import agreed
from analysis.gap.calibrate.calibration import Calibration
from analysis.gap.calibrate.fit import SEEDS, Fit
from analysis.gap.calibrate.relit import relit
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery, begun_twin
from analysis.gap.look.observation import Key, Observation
from foundation.cores import ahead
from foundation.errors import InputError
from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect, Parameter

Floats = NDArray[np.float64]

MOST_CHOICES = 5
"""Whole numbers that are each tried."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Signature:
    """How an effect of one strength shows.

    Attributes:
        effect: with its parameters.
        keys: of the figures.
        figures, means: differences from the base that all sets of random numbers agree on.
        plain: the same with their noise, as a pair: drawn to zero by nothing.
        sets: of random numbers.
        base, scenery: the camera, and shots under the light by which it takes the pictures with the
            effect.
    """

    effect: Effect
    keys: tuple[Key, ...]
    figures: Floats
    means: Floats
    plain: tuple[Floats, Floats]
    sets: int
    base: Base
    scenery: Scenery

    def on(self, keys: tuple[Key, ...]) -> Signature:
        """The signature on the figures of another model; one that was not seen did not move."""
        if keys == self.keys:
            return self
        place = {key: index for index, key in enumerate(self.keys)}
        found = np.array([place.get(key, -1) for key in keys])

        def moved(figures: Floats) -> Floats:
            return np.where(found < 0, 0.0, figures[found])

        plain = moved(self.plain[0]), self.plain[1]
        return dataclasses.replace(self, keys=keys, figures=moved(self.figures), plain=plain)


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """A signature held against a capture.

    Attributes:
        signature: how the effect would show.
        amount: how much of it there is; 1 where its strength is right.
        score: by how much chi-squared falls with that amount.
        norm: chi-squared of the signature by itself.
        absorbed: part of it that calibration takes up.
        left: what is left of the signature, in the calibrated space.
    """

    signature: Signature
    amount: float
    score: float
    norm: float
    absorbed: float
    left: Floats

    @property
    def effect(self) -> Effect:
        """The effect with the parameters of the signature."""
        return self.signature.effect

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


def signature(
    effect: Effect,
    known: Fit,
    *,
    seeds: Sequence[int] = SEEDS,
    base: Base | None = None,
) -> Signature | None:
    """How an effect shows; None where these frames cannot have it.

    Args:
        effect: with its parameters.
        known: the model, with the effects it has already.
        seeds: random numbers, once each, of those of `Fit.references`.
        base: figures of the camera, where they are not those of the fit.
    """
    return begun_signature(effect, known, seeds=seeds, base=base)()


def begun_signature(
    effect: Effect,
    known: Fit,
    *,
    seeds: Sequence[int] = SEEDS,
    base: Base | None = None,
) -> Callable[[], Signature | None]:
    """Begin to simulate how an effect shows: its first twin is begun to be looked at.

    See `signature` for the arguments, and `foundation.cores.ahead`.

    Returns:
        a function that waits for the twins and returns the signature, or None where these frames
        cannot have the effect.
    """
    effects = (*known.effects, effect)
    try:
        base, scenery = relit(
            known.lighting,
            base or known.base,
            known.scenery,
            before=known.effects,
            after=effects,
            seed=seeds[0],
        )
        under = functools.partial(begun_twin, scenery, base, effects=effects)
        first = under(seed=seeds[0])
    except InputError:
        return lambda: None
    return functools.partial(_shown, effect, known, base, scenery, seeds, under, first)


def _shown(
    effect: Effect,
    known: Fit,
    base: Base,
    scenery: Scenery,
    seeds: Sequence[int],
    under: Callable[..., Callable[[], Observation]],
    first: Callable[[], Observation],
) -> Signature | None:
    """How an effect shows.

    Args:
        effect: with its parameters.
        known: the model.
        base, scenery: the camera, and the light by which it takes the pictures with the effect.
        seeds: random numbers.
        under: begins a twin with the effect, of some `seed`.
        first: the first of them.
    """
    before = [known.references[seed] for seed in seeds]
    try:
        seen = [first(), *ahead(under(seed=seed) for seed in seeds[1:])]
    except InputError:
        return None
    after = [known.textured(one) for one in seen]
    figures, means = agreed(before, after)
    plain = (
        np.mean([b.figures[0] - a.figures[0] for a, b in zip(before, after, strict=True)], axis=0),
        np.mean([b.means[0] - a.means[0] for a, b in zip(before, after, strict=True)], axis=0),
    )
    return Signature(
        effect=effect,
        keys=before[0].keys,
        figures=figures,
        means=means,
        plain=plain,
        sets=len(after),
        base=base,
        scenery=scenery,
    )


def hold(shown: Signature, turned: Calibration, left: Floats) -> Evidence:
    """A signature against what is left of a capture.

    Args:
        shown: the signature.
        turned: the calibrated space.
        left: what is left of the capture there.
    """
    vector = turned.space.vector(shown.figures, shown.means)
    remains = turned.left(vector)
    norm = float(remains @ remains)
    whole = float(vector @ vector)
    along = float(remains @ left)
    amount = along / norm if norm > 0 else 0.0
    if amount < 0 and not signed(type(shown.effect)):
        amount = 0.0
    return Evidence(
        signature=shown,
        amount=amount,
        score=amount * (2 * along - amount * norm),
        norm=norm,
        absorbed=1.0 - norm / whole if whole > 0 else 1.0,
        left=remains,
    )


def strengths(kind: type[Effect]) -> list[Parameter]:
    """The parameters that make an effect vanish."""
    return [p for p in kind.parameters() if p.identity is not None]


def signed(kind: type[Effect]) -> bool:
    """Whether an effect may go either way."""
    return any(
        p.minimum < p.identity < p.maximum
        for p in strengths(kind)
        if p.identity is not None and not p.whole
    )


def starts(kind: type[Effect]) -> list[Effect]:
    """Effects from which a search begins: the default, and the other choices there are."""
    ranges: dict[str, list[float]] = {}
    for p in kind.parameters():
        if begins := beginnings_of(p):
            ranges[p.name] = begins
    tried = (dict(zip(ranges, one, strict=True)) for one in itertools.product(*ranges.values()))
    nothing = {p.name: p.identity for p in strengths(kind)}
    made = [
        kind(**values) for values in tried if not nothing or not nothing.items() <= values.items()
    ]
    for p in strengths(kind):
        identity = p.identity
        if p.per_colour and identity is not None and p.default != identity:
            # what all colours have in common may be calibration's
            for only in CHANNELS:
                one = {c: p.default if c == only else identity for c in CHANNELS}
                made.append(kind(**{p.name: Colours(**one)}))
        # a parameter that is off by default is a direction of its own
        if not (p.whole or p.stated) and p.default == p.identity:
            step = min(p.maximum - p.default, 0.1 * (p.maximum - p.minimum))
            on = Colours.of(p.default + step) if p.per_colour else p.default + step
            alone = {q.name: q.identity for q in strengths(kind)} | {p.name: on}
            made.append(kind(**alone))
    return made


def beginnings_of(p: Parameter) -> list[float]:
    """Values of a parameter that searches begin with; none where that is its default alone."""
    if p.starts:
        return list(p.starts)
    if not p.whole:
        return []
    low = p.minimum + 1 if p.identity == p.minimum else p.minimum
    return [float(v) for v in np.arange(low, p.maximum + 1)[:MOST_CHOICES]]


def scaled(effect: Effect, factor: float) -> Effect:
    """An effect like this one, so many times as strong, inside its range."""
    values: dict[str, Any] = {}
    for p in effect.parameters():
        value = getattr(effect, p.name)
        if p.identity is None or p.whole:
            continue
        if isinstance(value, Colours):
            values[p.name] = value.map(functools.partial(p.away, factor=factor))
        elif isinstance(value, float):
            values[p.name] = p.away(value, factor)
    return dataclasses.replace(effect, **values)


def comes_in_steps(effect: Effect) -> bool:
    """Whether the strength of an effect is a choice that cannot be scaled."""
    return scaled(effect, 0.5) == effect


def response_of(tried: Sequence[tuple[float, float]], before: float) -> float:
    """Power of the strength with which a signature grows, from the last two tries."""
    (f1, a1), (f2, a2) = tried[-2:]
    if min(f1 * f2, a1, a2) <= 0 or abs(np.log(f2 / f1)) < 0.3:
        return before  # too near each other to tell
    # the signature at f2 is a1 / a2 times that at f1
    return float(np.clip(np.log(a1 / a2) / np.log(f2 / f1), 0.8, 2.5))
