"""The detection limit of an effect: the strength at which it stands five standard errors from zero.

An effect of strength a shifts figures and mean image by s(a). Calibration takes up its part P s;
what is left, s' = s - P s in units of standard errors, is how far the fitted effect stands from
zero:

    z(a)^2 = |s'(a)|^2 / v = mean over i != j of s'_i . s'_j / v

for signatures s_i by different random numbers. Products of different ones have no noise of their
own in their mean, which the square of one signature would. The v is by how much more twins of the
camera scatter along s' than they would if its figures had nothing in common: 1 for an effect that
shows in a few figures, 2 or 3 for one that shows in histograms. A long way is not straight: one
that is calibrated to a strong effect is turned by what P s says and looked at again, so that only
what no camera without the effect shows is left.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.calibration import Calibration, calibration
from analysis.gap.calibrate.fit import FIRST_SEED, Fit, twins
from analysis.gap.calibrate.turning import turn
from analysis.gap.camera.base import Base
from analysis.gap.camera.handles import NOTHING
from analysis.gap.measure.case import variance_along
from analysis.gap.measure.signature import (
    comes_in_steps,
    scaled,
    signature,
    starts,
    strengths,
)
from analysis.gap.measure.twins_spread import Spread, spread_of
from sensor.effect import Effect

Floats = NDArray[np.float64]

STANDARD_ERRORS = 5.0
"""At the detection limit."""

LIMIT_SEEDS = tuple(range(FIRST_SEED + 100, FIRST_SEED + 116))
"""Random numbers of the signatures; no more of them than are needed."""

FEWEST = 4
SURE = 0.3
"""Standard error of z^2, as a part of it or of that at the limit, from which no more are asked. A
search stops where z comes out as 5, and stops too soon on noise."""

ROUNDS = 12
LEAST_Z = 0.2
"""Smaller ones are noise: where to go from there is a guess."""

CLOSE = 0.05
"""Of z; the noise of the twins is no smaller."""

WELL_SHOWN = 0.75
"""Of five standard errors: a search that ends below it has found no limit."""

CALIBRATIONS = 2
"""Steps of calibration that are made at most; the second one's are small."""

LEAST_TAKEN_UP = 100.0
"""Chi-squared taken up from which another step is made: ten standard errors are straight enough."""

SMALLEST, LARGEST = 2 * NOTHING, 1e4
"""Factors of the default strength between which a limit is looked for. Less than the smallest does
nothing but round otherwise."""


@dataclass(frozen=True, kw_only=True)
class Limit:
    """What one protocol tells of one effect.

    Attributes:
        name: of the effect.
        z: standard errors from zero at these parameters; 5 at a limit, anything for an effect that
            comes in steps or is too weak at its strongest.
        absorbed: part of its signature that calibration takes up.
        parameters: at that strength, with units.
        steps: whether its strength is a choice that cannot be scaled.
    """

    name: str
    z: float
    absorbed: float
    parameters: Mapping[str, Mapping[str, Any]]
    steps: bool

    @property
    def reached(self) -> bool:
        """Whether these frames show the effect at all."""
        return self.z > WELL_SHOWN * STANDARD_ERRORS


def limits(
    known: Fit,
    groups: int,
    effects: Iterable[Effect],
    watch: Callable[[str], None] = lambda name: None,
) -> dict[str, Limit]:
    """Detection limits by name of effect, in captures of so many groups of frames.

    Args:
        known: the camera without them.
        groups: of frames.
        effects: of any strength; those that come in steps are judged as they are.
        watch: told whose turn it is.
    """
    turned = calibration(known.space(groups), known.ways)
    spread = spread_of(known, groups)
    alone = twins(known.scenery, known.base, LIMIT_SEEDS, known.effects)
    others = {seed: known.textured(one) for seed, one in alone.items()}
    known = dataclasses.replace(known, references=others)
    found = {}
    for effect in effects:
        watch(effect.name)
        found[effect.name] = limit_of(effect, lambda one: shown(one, known, turned, spread))
    return found


def shown(effect: Effect, known: Fit, turned: Calibration, spread: Spread) -> tuple[float, float]:
    """Square of how many standard errors an effect stands from zero after calibration, and before;
    below 0 by chance.

    Args:
        effect: with its parameters.
        known: the camera without it.
        turned: the space of a capture, less what calibration takes up.
        spread: of the twins of the camera.
    """
    base = known.base
    vectors = _vectors(effect, known, base, turned)
    if vectors is None:
        return 0.0, 0.0
    whole = between(vectors)
    for _ in range(CALIBRATIONS):
        # what a camera without the effect shows like it, the one with it does not need
        amounts = turned.amounts(vectors.mean(axis=0))
        taken_up = between(vectors) - between(turned.left(vectors))
        if taken_up < LEAST_TAKEN_UP:
            break
        base = turn(base, known.ways, -amounts)
        again = _vectors(effect, known, base, turned)
        if again is None:
            break
        vectors = again
    left = turned.left(vectors)
    scatter = variance_along(spread, left.mean(axis=0))
    return between(left) / scatter, whole / scatter


def _vectors(effect: Effect, known: Fit, base: Base, turned: Calibration) -> Floats | None:
    """A camera with an effect against the one without, by as many sets of random numbers as it
    takes.
    """
    rows: list[Floats] = []
    for seed in LIMIT_SEEDS:
        one = signature(effect, known, seeds=(seed,), base=base)
        if one is None:
            return None
        rows.append(turned.space.vector(one.figures, one.means))
        if len(rows) >= FEWEST:
            left = turned.left(np.array(rows))
            if error_between(left) < SURE * max(between(left), STANDARD_ERRORS**2):
                break
    return np.array(rows)


def between(rows: Floats) -> float:
    """Mean product of two different rows."""
    n = len(rows)
    total = np.square(rows.sum(axis=0)).sum() - np.square(rows).sum()
    return float(total / (n * (n - 1)))


def error_between(rows: Floats) -> float:
    """Standard error of the mean product of two different rows: jackknife."""
    n = len(rows)
    without = np.array([between(np.delete(rows, k, axis=0)) for k in range(n)])
    return float(np.sqrt((n - 1) / n * np.square(without - without.mean()).sum()))


Shown = Callable[[Effect], tuple[float, float]]


def limit_of(effect: Effect, seen: Shown) -> Limit:
    """The strength at which an effect is seen at five standard errors.

    Args:
        effect: of the strength at which the search begins.
        seen: chi-squared of an effect after calibration, and before.
    """
    if comes_in_steps(effect):
        return _limit(effect, *seen(effect), steps=True)
    factor, power = 1.0, 1.0
    best: tuple[float, Effect, tuple[float, float]] | None = None
    below: tuple[float, float] | None = None
    above: tuple[float, float] | None = None
    weakest: tuple[Effect, tuple[float, float]] | None = None
    last: tuple[float, float] | None = None
    for _ in range(ROUNDS):
        now = scaled(effect, factor)
        chi2, whole = seen(now)
        z = float(np.sqrt(max(chi2, 0.0)))
        off = abs(np.log(max(z, LEAST_Z) / STANDARD_ERRORS))
        weaker = above is None or factor < above[0]
        if best is None or off < best[0] or (off <= best[0] and z > STANDARD_ERRORS and weaker):
            best = (off, now, (chi2, whole))
        if off < CLOSE:
            break
        if z > STANDARD_ERRORS:
            above = (factor, z)
            weakest = (now, (chi2, whole)) if weaker else weakest
        else:
            below = (factor, z)
            if scaled(effect, 2 * factor) == now:
                break  # as strong as it may be
        if last is not None and min(z, last[1]) > 0 and last[0] != factor:
            power = float(np.clip(np.log(z / last[1]) / np.log(factor / last[0]), 0.3, 4.0))
        last = (factor, z)
        factor = float(
            np.clip(
                factor * np.clip((STANDARD_ERRORS / max(z, LEAST_Z)) ** (1 / power), 0.01, 30.0),
                SMALLEST,
                LARGEST,
            )
        )
        if below is not None and above is not None and not below[0] < factor < above[0]:
            # what begins at a threshold has no power law: halve what is between
            factor = float(np.sqrt(below[0] * above[0]))
    assert best is not None, "at least one strength was tried"
    found = _limit(best[1], *best[2], steps=False)
    if found.reached or weakest is None:
        return found
    # it begins at a threshold: the weakest that is seen at all
    return _limit(weakest[0], *weakest[1], steps=False)


def default_of(kind: type[Effect]) -> Effect:
    """The effect with its default parameters, or the first start that is not without effect."""
    effect = kind()
    off = [getattr(effect, p.name) == p.identity for p in strengths(kind)]
    if not off or not all(off):
        return effect
    return starts(kind)[0]


def effect_of(limit: Limit, kind: type[Effect]) -> Effect:
    """The effect at its detection limit."""
    return dataclasses.replace(
        default_of(kind), **{name: entry["value"] for name, entry in limit.parameters.items()}
    )


def _limit(effect: Effect, chi2: float, whole: float, *, steps: bool) -> Limit:
    return Limit(
        name=effect.name,
        z=float(np.sqrt(max(chi2, 0.0))),
        absorbed=float(np.clip(1.0 - chi2 / whole, 0.0, 1.0)) if whole > 0 else 1.0,
        parameters={
            p.name: {"value": value, "unit": p.unit}
            for p in effect.parameters()
            for value in [getattr(effect, p.name)]
            if isinstance(value, (int, float))
        },
        steps=steps,
    )
