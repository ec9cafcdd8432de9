"""Calibrate a base camera to a capture: twins, the difference, the knobs, and again."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.calibration import Calibration, calibration
from analysis.gap.calibrate.fit import (
    TURNED_SEEDS,
    chi2_of_twins,
    seeds_of,
    some,
    spaces_by,
    together,
    twins,
    with_keys,
)
from analysis.gap.calibrate.nuisance import Directions, directions, moved_twins, of_the_light
from analysis.gap.calibrate.space import Space
from analysis.gap.calibrate.turning import tune, turn
from analysis.gap.camera.base import Base
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_ways import changed, light_ways
from analysis.gap.camera.twin import NOT_CLIPPED, Scenery
from analysis.gap.look.observation import Observation
from sensor.effect import Effect

Floats = NDArray[np.float64]

MOST_STEPS = 10
"""Iterations of Gauss-Newton at most, unless a caller wants others."""

STEP_TWINS = 4
"""Bodies that are simulated of each camera on the way."""

CLOSE = 0.1
"""Part of chi-squared that a last step takes off at most, of a model that fits."""

STUCK = 0.03
"""The same of one that does not, of which more steps may be worth their time."""

STUCK_OF_EXCESS = 0.1
"""The same of what chi-squared has beyond that: a misfit in few figures is little of the whole."""

WORTH_A_STEP = 30.0
"""Fall of chi-squared that directions promise, of a model that fits, from which one more step is
made: by chance it is about the number of knobs at most, and ten where nothing is off."""

LEAST_FALL = 0.005
"""Part of chi-squared that no step is worth, wherever it is."""

SHORTER = (0.4, 0.15)
"""Parts of a step that are tried where all of it leads uphill."""

PATIENCE = 1
"""Steps in a row that may take off less than that, far from the end."""

FITS_MISFIT = 1.0
"""Misfit up to which a model fits as well as chance allows."""

FAR = 2.0
"""Misfit of a model that does not fit."""

A_LONG_WAY = 0.3
"""Part of chi-squared that is left where directions are read anew: they change on a long way, and
reading them is worth five steps."""

BY_MOMENTS = ("clamp",)
"""Knobs that stay where moments have put them, until an effect is there that may have been taken
for one. All channels of a frame share a clamp's noise: what a few show by chance looks certain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refined:
    """A camera, and its difference from a capture.

    Attributes:
        base, effects: the camera.
        bodies: a few of its twins by seed.
        light: where the difference has units of standard errors, less what light can take up.
        gap: the difference.
        expected: chi-squared that one of its twins has from the others.
    """

    base: Base
    effects: tuple[Effect, ...]
    bodies: Mapping[int, Observation]
    light: Calibration
    gap: Floats
    expected: float

    @property
    def lit(self) -> frozenset[str]:
        """Labels of the shots under a lamp."""
        return next(iter(self.bodies.values())).lit

    @property
    def space(self) -> Space:
        """Where the difference has units of standard errors."""
        return self.light.space

    @cached_property
    def chi2(self) -> float:
        """Chi-squared of the difference, less what a change of the light can take up."""
        return float(np.square(self.light.left(self.gap)).sum())

    @property
    def chi2_of_figures(self) -> float:
        """Chi-squared of the figures alone, of which light takes up nothing."""
        return float(np.square(self.gap[: len(self.space.keys)]).sum())

    @property
    def misfit(self) -> float:
        """Chi-squared over what its own twins have of each other: about 1 where it fits."""
        return self.chi2 / self.expected

    @property
    def deviance(self) -> float:
        """-2 log likelihood, up to a constant: chi-squared, and what a wide picture pays for it.

        Fixed pattern noise widens the errors of every block. By chi-squared alone too much of it
        would fit best.
        """
        of_blocks = self.space.log_widths[len(self.space.keys) :]
        return self.chi2 + 2.0 * float(of_blocks.sum())


def refined(
    base: Base, seen: Observation, scenery: Scenery, effects: Sequence[Effect] = ()
) -> Refined:
    """A camera against a capture, by a few twins.

    Args:
        base: calibrated, or on its way.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
    """
    alone = twins(scenery, base, seeds_of(STEP_TWINS), effects)
    bodies = together(alone.values())
    both = with_keys(seen, bodies.keys)
    space, of_one = spaces_by(bodies, base, scenery, both, in_common=bool(effects))
    light = calibration(space, of_the_light(base, scenery, bodies))
    return Refined(
        base=base,
        effects=tuple(effects),
        bodies=alone,
        light=light,
        gap=space.of(both),
        expected=chi2_of_twins(of_one, bodies),
    )


def refine(
    start: Base,
    seen: Observation,
    scenery: Scenery,
    effects: Sequence[Effect] = (),
    *,
    steps: int = MOST_STEPS,
    tuned: str = "",
) -> Refined:
    """Gauss-Newton on the knobs against simulated frames: the base whose twins look like these.

    Args:
        start: by moments.
        seen: the frames that fit.
        scenery: their light and shots.
        effects: what the camera has besides.
        steps: iterations at most.
        tuned: name of the effect whose parameters are fitted along.
    """
    return further(refined(start, seen, scenery, effects), seen, scenery, steps=steps, tuned=tuned)


def further(
    begun: Refined,
    seen: Observation,
    scenery: Scenery,
    *,
    steps: int = MOST_STEPS,
    tuned: str = "",
) -> Refined:
    """Gauss-Newton on the knobs, from a camera that is held against the frames already.

    Args:
        begun: the camera, with its effects.
        seen: the frames that fit.
        scenery: their light and shots, as they were for it.
        steps: iterations at most.
        tuned: name of the effect whose parameters are fitted along.
    """

    def part_of_a_step(point: Refined, part: float) -> Refined:
        amounts = part * calibration(point.space, ways).amounts(point.gap)
        return stepped(point, ways, amounts, seen, scenery, tuned={tuned})

    def promise(point: Refined) -> float:
        left = calibration(point.space, ways).left(point.gap)
        return point.chi2 - float(left @ left)

    def promising(point: Refined) -> bool:
        return promise(point) > STUCK * point.chi2

    def downhill(point: Refined) -> Refined | None:
        parts = (1.0, *SHORTER) if promising(point) else (1.0,)
        tried = (part_of_a_step(point, part) for part in parts)
        return next((one for one in tried if better(one, point)), None)

    best = read_at = begun
    ways = _directions(best, scenery)
    slow = 0
    for _ in range(steps):
        next_one = downhill(best)
        if next_one is None:
            # these directions are not those of this place, if they promise anything
            if best is read_at or slow or not promising(best):
                break
            ways, read_at = _directions(best, scenery), best
            continue
        slow = slow + 1 if best.deviance - next_one.deviance < _least_fall(best) else 0
        best = next_one
        # a few figures that are off are little of a whole that fits, and one more step mends them
        nearly = best.misfit <= FITS_MISFIT and promise(best) > WORTH_A_STEP
        if slow > (PATIENCE if best.misfit > FAR else 0) and not nearly:
            break
        if best.misfit > FITS_MISFIT and best.chi2 < A_LONG_WAY * read_at.chi2:
            ways, read_at = _directions(best, scenery), best
    return best


def stepped(
    point: Refined,
    ways: Directions,
    amounts: Floats,
    seen: Observation,
    scenery: Scenery,
    *,
    tuned: Collection[str],
) -> Refined:
    """A camera that is moved, against a capture.

    Args:
        point: where it is.
        ways, amounts: how far it is moved in which directions.
        seen: the frames that fit.
        scenery: their light and shots.
        tuned: names of the effects whose parameters move along.
    """
    moved_on = (tune(e, ways, amounts) if e.name in tuned else e for e in point.effects)
    base = turn(point.base, ways, amounts, still=() if point.effects else BY_MOMENTS)
    if not scenery.light.known:
        base = as_bright(base, point, seen, scenery)
    return refined(base, seen, scenery, tuple(moved_on))


def better(one: Refined, than: Refined) -> bool:
    """Likelier; or as good as chance allows, with figures that are nearer.

    A picture says little of a pattern behind the floor of the light, and is likelier without it.
    """
    nearer = one.chi2_of_figures < than.chi2_of_figures - LEAST_FALL * than.chi2
    return one.deviance < than.deviance or (one.misfit <= FITS_MISFIT and nearer)


def _least_fall(point: Refined) -> float:
    """What a further step must take off chi-squared."""
    chi2 = point.chi2
    excess = chi2 - FITS_MISFIT * point.expected
    if excess < 0:
        return CLOSE * chi2
    return max(LEAST_FALL * chi2, min(STUCK * chi2, STUCK_OF_EXCESS * excess))


def _directions(point: Refined, scenery: Scenery) -> Directions:
    references = some(point.bodies, TURNED_SEEDS)
    return directions(
        point.base, scenery, moved_twins(point.base, scenery, references, point.effects)
    )


def as_bright(base: Base, point: Refined, seen: Observation, scenery: Scenery) -> Base:
    """A base whose twins are as bright as the frames, of one from which a step leads to it.

    Light that was read from the frames themselves is as bright as they are. As a knob its level
    would be free, as such light says nothing: a gain that is too high would go with too little
    light, and every variance be right.

    Args:
        base: behind the step.
        point: in front of it, with its twins.
        seen: the frames that fit.
        scenery: their light and shots.
    """
    ours = together(point.bodies.values()).means.mean(axis=0)
    theirs = seen.means.mean(axis=0)
    level = dict(base.level)
    for lamp in level:
        shots = [k for k, s in enumerate(scenery.shots) if not s.dark and lamp_of(s) == lamp]
        dn = theirs[shots] - base.black_dn[None, :, None]
        twins_dn = ours[shots] - base.black_dn[None, :, None]
        good = theirs[shots] < NOT_CLIPPED * scenery.view.top_dn
        above, below = ((good * one).sum(axis=(0, 2)) for one in (dn, twins_dn))
        lit = (above > 0) & (below > 0)
        level[lamp] = level[lamp] * np.divide(above, below, out=np.ones_like(above), where=lit)
    return dataclasses.replace(base, level=level)


def as_shown(point: Refined, scenery: Scenery) -> Scenery:
    """The scenery with its light as the frames show it.

    Args:
        point: a camera against the frames, under this scenery.
        scenery: its light is known.
    """
    light = scenery.light
    if not light.known:
        return scenery
    ways = light_ways(point.base, scenery, next(iter(point.bodies.values())))
    shown = changed(light, light.rates, ways, point.light.amounts(point.gap))
    return dataclasses.replace(scenery, light=shown)
