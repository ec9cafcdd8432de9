"""A calibrated camera and everything that is known around it: twins, spreads, directions."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.body_share import body_share
from analysis.gap.calibrate.calibration import Calibration, calibration
from analysis.gap.calibrate.figure_errors import figure_variances, never_moved
from analysis.gap.calibrate.nuisance import Directions, directions, moved_twins
from analysis.gap.calibrate.relit import Lighting, lighting
from analysis.gap.calibrate.space import Space, space_of
from analysis.gap.calibrate.wide import Beyond, beyond, fair, widened
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery, begun_twin
from analysis.gap.look.observation import Key, Observation
from analysis.gap.look.texture import FAMILY, texture
from foundation.cores import ahead
from sensor.effect import Effect

Floats = NDArray[np.float64]

FIRST_SEED = 7_000_001
"""Of the twins; a user's own capture has small seeds."""

TURNED_SEEDS = (FIRST_SEED, FIRST_SEED + 1)
"""Of the twins whose knobs are turned."""

SEEDS = (FIRST_SEED + 500, FIRST_SEED + 501)
"""Of the twins that show what a suspect does. None of those whose mean is the expectation: what a
change does to a figure goes with the figure's own noise, and would lean away from that mean."""

FINAL_SEEDS = (*SEEDS, FIRST_SEED + 502)
"""Of those of finalists: their noise is then below that of frames."""


def seeds_of(count: int) -> range:
    """Random numbers of so many bodies."""
    return range(FIRST_SEED, FIRST_SEED + count)


def together(several: Iterable[Observation]) -> Observation:
    """Several observations of one plan as groups of one, with the keys that all have."""
    seen = list(several)
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
    """An observation with the figures of these keys alone, (groups, keys); one it lacks is 0."""
    if seen.keys == keys:
        return seen
    place = {key: index for index, key in enumerate(seen.keys)}
    figures = np.zeros((seen.groups, len(keys)))
    for index, key in enumerate(keys):
        if key in place:
            figures[:, index] = seen.figures[:, place[key]]
    return dataclasses.replace(seen, keys=keys, figures=figures)


def twins(
    scenery: Scenery, base: Base, seeds: Iterable[int], effects: Sequence[Effect] = ()
) -> dict[int, Observation]:
    """Bodies of a camera by their seed, a group of frames each."""
    wanted = tuple(seeds)
    begun = (begun_twin(scenery, base, effects=effects, seed=seed) for seed in wanted)
    return dict(zip(wanted, ahead(begun), strict=True))


def some(twins: Mapping[int, Observation], seeds: Sequence[int]) -> dict[int, Observation]:
    """The twins that have these seeds, by their seed, in the order of the seeds."""
    return {seed: twins[seed] for seed in seeds}


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A calibrated base and everything that is known around it.

    Attributes:
        base: the camera.
        effects: what it has besides.
        scenery: light and shots.
        bodies: its twins, with texture.
        again: other frames of the first few of these.
        variances: of each figure of one group.
        shares: parts of these that are a body's.
        more: what blocks of its twins have beyond noise, fixed pattern and light.
        ways: what calibration can take up.
        picture: calibration of one group's mean image, by which texture is read.
        references: more twins, of `FINAL_SEEDS`, textured like a capture.
    """

    base: Base
    effects: tuple[Effect, ...]
    scenery: Scenery
    bodies: Observation
    again: Observation
    variances: Floats
    shares: Floats
    more: Beyond
    ways: Directions
    picture: Calibration
    references: Mapping[int, Observation]

    @cached_property
    def lighting(self) -> Lighting | None:
        """What a change of the light can do to mean images."""
        return lighting(self.base, self.scenery, self.bodies)

    def calibration_for(self, seen: Observation) -> Calibration:
        """The space in which a capture is compared, less what calibration takes up.

        Args:
            seen: the capture, textured.
        """
        return calibration(self.space(seen.groups, seen=seen), self.ways)

    def space(self, groups: int, *, floors: bool = True, seen: Observation | None = None) -> Space:
        """Where captures of so many groups of frames are compared; see `space_of`."""
        space = space_of(
            self.bodies,
            self.variances,
            self.base,
            self.scenery,
            groups,
            floors=floors,
            seen=seen,
            shares=self.shares,
        )
        if seen is not None:
            spread = np.hypot(space.spread, never_moved(self.bodies, seen))
            space = dataclasses.replace(space, spread=spread)
        return widened(space, self.more, self.bodies, seen)

    def calibration_of_twins(self) -> Calibration:
        """The space in which its twins are compared with each other."""
        return calibration(self.space(1, floors=False), self.ways)

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


ALONE = 2.0
"""What one twin of many adds at most to a standard error, as a factor."""


def by_the_others(bodies: Observation, variances: Floats, scenery: Scenery) -> Floats:
    """Standard errors by all twins over those by all but one, for each of them, (twins, figures).

    A twin that takes part in a variance is never far outside of it; a capture takes no part. Where
    one twin alone moved, the others know of no errors at all: they are believed up to `ALONE`.

    Args:
        bodies: twins of one camera.
        variances: what they say of their figures; see `figure_variances`.
        scenery: light and shots.
    """
    others = (np.delete(bodies.figures, k, axis=0) for k in range(bodies.groups))
    without = [
        figure_variances(dataclasses.replace(bodies, figures=rest), scenery.light.known)
        for rest in others
    ]
    return np.minimum(np.sqrt(variances / np.array(without)), ALONE)


def spaces_by(
    bodies: Observation,
    base: Base,
    scenery: Scenery,
    seen: Observation,
    *,
    in_common: bool = True,
) -> tuple[Space, Space]:
    """The spaces of a capture and of one group of frames, by a few twins of a camera alone.

    Args:
        bodies: the twins.
        base: the camera.
        scenery: light and shots.
        seen: the capture, with the keys of the twins.
        in_common: whether what blocks of a shot have in common is told apart; see `around`.
    """
    variances = figure_variances(bodies, scenery.light.known)
    of_one = space_of(bodies, variances, base, scenery, 1, floors=False)
    of_all = space_of(bodies, variances, base, scenery, seen.groups, seen=seen)
    more = beyond(of_one, base, bodies, in_common=in_common)
    return widened(of_all, more, bodies, seen), widened(of_one, more, bodies)


def chi2_of_twins(space: Space, bodies: Observation) -> float:
    """Chi-squared that one of so many twins has from the others, in the mean.

    More than one per coordinate where coordinates have something in common: a column that is
    brighter shows in every block that it crosses. Never less: it is by chance that a few twins have
    less of the errors that they make themselves.

    Args:
        space: of one group of frames.
        bodies: the twins.
    """
    count = bodies.groups
    each = np.array([fair(count) * space.of(bodies, slice(k, k + 1)) for k in range(count)])
    return max(float(np.square(each).sum() / count), float(each.shape[1]))


TWINS = 24
"""Bodies simulated around a model: their mean is what is expected, their spread the error."""

ONE_IN = 3
"""Of so many bodies one is looked at twice."""

OTHER_FRAMES = 1000
"""From the seed of a body to that of other frames of it."""


def around(
    base: Base, scenery: Scenery, effects: Sequence[Effect] = (), *, count: int = TWINS
) -> Fit:
    """Everything around a model: twins, spreads, directions.

    What blocks have in common is told apart where effects make them have it. A clamp's noise is the
    base camera's own: beside it nulls were looked at without, and one of 43 had an ambient light
    of 0.7 e- of such offsets with.

    Args:
        base: the camera.
        scenery: light and shots.
        effects: what it has besides.
        count: of the bodies that are simulated.
    """
    alone = twins(scenery, base, seeds_of(count), effects)
    plain = together(alone.values())
    variances = figure_variances(plain, scenery.light.known)
    other = moved_twins(base, scenery, some(alone, TURNED_SEEDS), effects)
    plain_ways = directions(base, scenery, other)
    of_one = space_of(plain, variances, base, scenery, 1, floors=False)
    more = beyond(of_one, base, plain, in_common=bool(effects))
    picture = calibration(widened(of_one, more, plain), plain_ways)
    bodies = with_texture(plain, picture, scenery, fair(plain.groups))
    twice = count // ONE_IN
    begun = (
        begun_twin(scenery, base, effects=effects, seed=seed + OTHER_FRAMES, body=seed)
        for seed in seeds_of(twice)
    )
    again = with_texture(together(ahead(begun)), picture, scenery, fair(plain.groups))
    once = dataclasses.replace(bodies, figures=bodies.figures[:twice], means=bodies.means[:twice])
    ways = directions(base, scenery, other.seen_by(lambda one: with_texture(one, picture, scenery)))
    variances = figure_variances(bodies, scenery.light.known)
    return Fit(
        base=base,
        effects=tuple(effects),
        scenery=scenery,
        bodies=bodies,
        again=again,
        variances=variances,
        shares=body_share(once, again),
        more=more,
        ways=ways,
        picture=picture,
        references={
            seed: with_keys(with_texture(one, picture, scenery), bodies.keys)
            for seed, one in twins(scenery, base, FINAL_SEEDS, effects).items()
        },
    )
