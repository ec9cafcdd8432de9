"""A calibrated camera and everything that is known around it: twins, spreads, directions."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.calibration import Calibration, calibration
from analysis.gap.calibrate.nuisance import Directions, directions, moved_twins
from analysis.gap.calibrate.space import figure_variances, space_of
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery, twin
from analysis.gap.look.observe import EVERY_SHOT, Key, Observation
from analysis.gap.look.texture import FAMILY, texture
from sensor.effect import Effect

Floats = NDArray[np.float64]

FIRST_SEED = 7_000_001
"""Of the twins; a user's own capture has small seeds."""

SEEDS = (FIRST_SEED, FIRST_SEED + 1)
"""Of the twins that show what a change does."""

FINAL_SEEDS = (*SEEDS, FIRST_SEED + 2)
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
    """The same with these keys alone; a figure that is missing is 0."""
    if seen.keys == keys:
        return seen
    place = {key: index for index, key in enumerate(seen.keys)}
    figures = np.zeros((seen.groups, len(keys)))
    for index, key in enumerate(keys):
        if key in place:
            figures[:, index] = seen.figures[:, place[key]]
    return dataclasses.replace(seen, keys=keys, figures=figures)


def twins(
    scenery: Scenery, base: Base, count: int, effects: Sequence[Effect] = ()
) -> dict[int, Observation]:
    """As many bodies of a camera by their seed, a group of frames each."""
    return {s: twin(scenery, base, effects=effects, seed=s) for s in seeds_of(count)}


def some(twins: Mapping[int, Observation], seeds: Sequence[int]) -> dict[int, Observation]:
    """Those of some seeds."""
    return {seed: twins[seed] for seed in seeds}


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
        references: its twins of `FINAL_SEEDS`, textured like a capture.
    """

    base: Base
    effects: tuple[Effect, ...]
    scenery: Scenery
    bodies: Observation
    variances: Floats
    ways: Directions
    picture: Calibration
    references: Mapping[int, Observation]

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


TWINS = 16


def around(base: Base, scenery: Scenery, effects: Sequence[Effect] = ()) -> Fit:
    """Everything around a model: twins, spreads, directions."""
    lit = lit_by_label(scenery)
    alone = twins(scenery, base, TWINS, effects)
    plain = together(alone.values())
    variances = figure_variances(plain, lit, scenery.light.known)
    other = moved_twins(base, scenery, some(alone, SEEDS), effects)
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
        references={
            seed: with_keys(with_texture(one, picture, scenery), bodies.keys)
            for seed, one in some(alone, FINAL_SEEDS).items()
        },
    )
