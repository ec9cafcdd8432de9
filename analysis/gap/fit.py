"""Calibrate the base camera to a capture: twins, the difference, the knobs, and again."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.arithmetic import IN_FRACTIONS, OF_WHOLE_SAMPLES, RULES
from analysis.gap.base import Base
from analysis.gap.calibration import Calibration, calibration
from analysis.gap.nuisance import Directions, directions, moved, moved_twins
from analysis.gap.observe import EVERY_SHOT, Key, Observation
from analysis.gap.space import Space, figure_variances, space_of
from analysis.gap.texture import FAMILY, texture
from analysis.gap.twin import Scenery, twin
from sensor.effect import Effect

Floats = NDArray[np.float64]

FIRST_SEED = 7_000_001
"""Of the twins; a user's own capture has small seeds."""

SEEDS = (FIRST_SEED, FIRST_SEED + 1)
"""Of the twins that show what a change does."""


def seeds_of(count: int) -> range:
    """Random numbers of so many bodies."""
    return range(FIRST_SEED, FIRST_SEED + count)


def together(seen: Sequence[Observation]) -> Observation:
    """Several observations of one plan as groups of one, with the keys that all have."""
    shared = set(seen[0].keys).intersection(*(set(o.keys) for o in seen[1:]))
    keys = tuple(key for key in seen[0].keys if key in shared)
    return dataclasses.replace(
        seen[0],
        keys=keys,
        figures=np.concatenate([with_keys(o, keys).figures for o in seen]),
        means=np.concatenate([o.means for o in seen]),
        noise=np.mean([o.noise for o in seen], axis=0),
    )


def with_keys(seen: Observation, keys: tuple[Key, ...]) -> Observation:
    """The same with these keys alone; a figure that is missing is 0."""
    if seen.keys == keys:
        return seen
    place = {key: index for index, key in enumerate(seen.keys)}
    figures = np.zeros((seen.groups, len(keys)))
    for index, key in enumerate(keys):
        if key in place:
            figures[:, index] = seen.figures[:, place[key]]
    return dataclasses.replace(seen, keys=keys, figures=figures)


def twins(scenery: Scenery, base: Base, count: int, effects: Sequence[Effect] = ()) -> Observation:
    """As many bodies of a camera, a group of frames each."""
    return together([twin(scenery, base, effects=effects, seed=s) for s in seeds_of(count)])


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A calibrated base and everything that is known around it.

    Attributes:
        base: the camera.
        effects: what it has besides.
        scenery: light and shots.
        bodies: its twins, with texture.
        variances: of each figure of one group.
        ways: what calibration can take up.
        picture: calibration of one group's mean image, by which texture is read.
    """

    base: Base
    effects: tuple[Effect, ...]
    scenery: Scenery
    bodies: Observation
    variances: Floats
    ways: Directions
    picture: Calibration

    def calibration_for(self, seen: Observation) -> Calibration:
        """The space in which a capture is compared, less what calibration takes up.

        Args:
            seen: the capture, textured.
        """
        space = space_of(
            self.bodies, self.variances, self.base, self.scenery, seen.groups, seen=seen
        )
        return calibration(space, self.ways)

    def calibration_of_twins(self) -> Calibration:
        """The space in which its twins are compared with each other."""
        space = space_of(self.bodies, self.variances, self.base, self.scenery, 1, floors=False)
        return calibration(space, self.ways)

    def textured(self, seen: Observation) -> Observation:
        """An observation with the texture of its residual image, on this fit's keys."""
        return with_keys(with_texture(seen, self.picture, self.scenery), self.bodies.keys)


def with_texture(
    seen: Observation, picture: Calibration, scenery: Scenery, fair: float = 1.0
) -> Observation:
    """An observation with figures of what is left of its mean images, group by group.

    Args:
        seen: the observation.
        picture: the space of one group's mean image.
        scenery: light and shots.
        fair: factor of the residuals of those that are part of what they are compared with.
    """
    space = picture.space
    plain = with_keys(seen, space.keys)
    keys: list[Key] = []
    rows = []
    count = len(space.keys)
    size = int(np.prod(space.shape))
    for k in range(seen.groups):
        left = picture.left(fair * space.of(plain, slice(k, k + 1)))[count : count + size]
        images = left.reshape(space.shape)
        found: list[tuple[Key, float]] = []
        for s, shot in enumerate(scenery.shots):
            for c, channel in enumerate(seen.channels):
                for name, value in texture(images[s, c], seen.grid).items():
                    key = Key(shot=shot.label, lattice=channel, family=FAMILY, statistic=name)
                    found.append((key, value))
        keys = [key for key, _ in found]
        rows.append([value for _, value in found])
    return dataclasses.replace(
        plain,
        keys=(*plain.keys, *keys),
        figures=np.concatenate([plain.figures, np.array(rows)], axis=1),
    )


def fair(count: int) -> float:
    """What the difference of one of so many from their mean lacks, against that of another."""
    return float(np.sqrt((count + 1) / (count - 1)))


def lit_by_label(scenery: Scenery) -> dict[str, bool]:
    """Whether each shot is lit; what is counted over all shots is not."""
    return {EVERY_SHOT: False} | {shot.label: not shot.dark for shot in scenery.shots}


MOST_STEPS = 10
STEP_TWINS = 4

CLOSE = 0.1
"""Part of chi-squared that a last step takes off at most, of a model that fits."""

STUCK = 0.03
"""The same of one that does not, of which more steps may be worth their time."""

STUCK_OF_EXCESS = 0.1
"""The same of what chi-squared has beyond that: a misfit in few figures is little of the whole."""

LEAST_FALL = 0.005
"""Part of chi-squared that no step is worth, wherever it is."""

PATIENCE = 1
"""Steps in a row that may take off less than that, far from the end."""

FITS = 1.0
"""Chi-squared per coordinate up to which a model fits as well as chance allows."""

FAR = 2.0
"""Chi-squared per coordinate of a model that does not fit."""

A_LONG_WAY = 0.8
"""Part of chi-squared that is left where directions are read anew: they change on a long way."""

MOST_GAIN_STEP = 0.4


def refine(
    start: Base,
    seen: Observation,
    scenery: Scenery,
    effects: Sequence[Effect] = (),
    *,
    steps: int = MOST_STEPS,
    tuned: str = "",
) -> tuple[Base, tuple[Effect, ...]]:
    """Gauss-Newton on the knobs against simulated frames: the base whose twins look like these.

    Args:
        start: by moments.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
        steps: iterations at most.
        tuned: name of the effect whose parameters are fitted along.

    Returns:
        The base, and the effects.
    """

    def at(base: Base, effects: tuple[Effect, ...]) -> _Point:
        space, gap = _gap(base, seen, scenery, effects)
        return _Point(base=base, effects=effects, space=space, gap=gap, chi2=float(gap @ gap))

    def stepped(point: _Point) -> tuple[Base, tuple[Effect, ...]]:
        amounts = calibration(point.space, ways).amounts(point.gap)
        effects = (tune(e, ways, amounts) if e.name == tuned else e for e in point.effects)
        return turn(point.base, ways, amounts), tuple(effects)

    def promised(point: _Point) -> float:
        left = calibration(point.space, ways).left(point.gap)
        return point.chi2 - float(left @ left)

    best = read_at = at(start, tuple(effects))
    ways = _directions(best.base, scenery, best.effects)
    slow = 0
    for _ in range(steps - 1):
        next_one = at(*stepped(best))
        count, fall = len(next_one.gap), best.chi2 - next_one.chi2
        if fall <= 0:
            # uphill: these directions are not those of this place, if they promise anything
            if best is read_at or promised(best) < STUCK * best.chi2:
                return best.base, best.effects
            ways, read_at = _directions(best.base, scenery, best.effects), best
            continue
        slow = slow + 1 if fall < _least_fall(best.chi2, count) else 0
        best = next_one
        if slow > (PATIENCE if best.chi2 > FAR * count else 0):
            break
        if FITS * count < best.chi2 < A_LONG_WAY * read_at.chi2:
            ways, read_at = _directions(best.base, scenery, best.effects), best
    return stepped(best)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Point:
    """A camera, and its difference from a capture."""

    base: Base
    effects: tuple[Effect, ...]
    space: Space
    gap: Floats
    chi2: float


def _least_fall(chi2: float, count: int) -> float:
    """What a further step must take off chi-squared."""
    excess = chi2 - FITS * count
    if excess < 0:
        return CLOSE * chi2
    return max(LEAST_FALL * chi2, min(STUCK * chi2, STUCK_OF_EXCESS * excess))


def misfit(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect] = ()
) -> float:
    """Chi-squared of a base per coordinate: about 1 where it fits.

    Args:
        base: calibrated.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
    """
    return float(np.square(_gap(base, seen, scenery, effects)[1]).mean())


def counted(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect] = ()
) -> Base:
    """The base with the arithmetic of its demosaicer that fits best; the same where it fits.

    Processing behind a demosaicer that counts in whole numbers hides from `arithmetic_of` that it
    does.

    Args:
        base: calibrated.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
    """
    if scenery.body.pixels != "rgb8":
        return base

    best, least = base, misfit(base, seen, scenery, effects)
    if least < FAR:
        return base
    for rule in (IN_FRACTIONS, *RULES, OF_WHOLE_SAMPLES):
        other = dataclasses.replace(base, arithmetic=rule)
        if (now := misfit(other, seen, scenery, effects)) < least:
            best, least = other, now
    return best


def _gap(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect]
) -> tuple[Space, Floats]:
    """The difference of a capture from a few twins, and the space it is in."""
    bodies = twins(scenery, base, STEP_TWINS, effects)
    both = with_keys(seen, bodies.keys)
    variances = figure_variances(bodies, lit_by_label(scenery), scenery.light.known)
    space = space_of(bodies, variances, base, scenery, seen.groups, seen=both)
    return space, space.of(both)


def _directions(base: Base, scenery: Scenery, effects: Sequence[Effect]) -> Directions:
    return directions(base, scenery, moved_twins(base, scenery, SEEDS, effects))


def turn(base: Base, ways: Directions, amounts: Floats) -> Base:
    """A base with its knobs turned."""
    for knob, amount in zip(ways.knobs, amounts, strict=False):
        by = float(amount)
        if knob.name == "gain" or knob.name.startswith("level"):
            by = float(np.clip(by, -MOST_GAIN_STEP, MOST_GAIN_STEP))
        base = base.moved(knob.name, knob.channel, by)
    return base


def tune(effect: Effect, ways: Directions, amounts: Floats) -> Effect:
    """An effect with its parameters moved, each inside its range."""
    moves = dict(zip(ways.tuned, map(float, amounts[len(ways.knobs) :]), strict=False))
    return moved(effect, {h: by for h, by in moves.items() if h.effect == effect.name})


TWINS = 16


def around(base: Base, scenery: Scenery, effects: Sequence[Effect] = ()) -> Fit:
    """Everything around a model: twins, spreads, directions."""
    lit = lit_by_label(scenery)
    plain = twins(scenery, base, TWINS, effects)
    variances = figure_variances(plain, lit, scenery.light.known)
    other = moved_twins(base, scenery, SEEDS, effects)
    plain_ways = directions(base, scenery, other)
    picture = calibration(space_of(plain, variances, base, scenery, 1, floors=False), plain_ways)
    bodies = with_texture(plain, picture, scenery, fair(plain.groups))
    ways = directions(base, scenery, other.seen_by(lambda one: with_texture(one, picture, scenery)))
    variances = figure_variances(bodies, lit, scenery.light.known)
    return Fit(
        base=base,
        effects=tuple(effects),
        scenery=scenery,
        bodies=bodies,
        variances=variances,
        ways=ways,
        picture=picture,
    )
