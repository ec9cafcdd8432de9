"""The light under which a camera with one more effect takes the same pictures.

A camera is calibrated under light as the frames show it; see `refine.as_shown`. What an effect does
to the light is part of that light already: behind a lens that darkens the corners twins without it
are lit by darker corners. With the effect under the same light they would be darkened twice, and
whatever tells where patches lie to a part of a code would speak against the very effect that the
frames have. So the light gives back what calibration takes up of the effect's mean images. These
are held against the stated light, as always, and tell how much of the effect there is.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.space import LIGHT_FLOOR
from analysis.gap.camera.base import Base
from analysis.gap.camera.light_ways import FREE, LightWay, changed, image_ways, level_ways
from analysis.gap.camera.twin import Scenery
from analysis.gap.camera.twin_light import light_means, of_the_light
from analysis.gap.look.observation import Observation
from sensor.effect import Effect

Floats = NDArray[np.float64]

LEAST_DN = 0.05
"""Change of the light, where it is largest, from which twins are lit anew."""

NOTHING_DN2 = 1e-9
"""Variance of a block that is black and without noise."""

ROUNDS = 6
"""Times at most that the light is read anew: what an effect takes off is a part of what it is
given."""

RESPONSES = (0.1, 10.0)
"""By which light may be seen through effects, against what the camera alone sees of it: responses
that are three times as high as stated turn a change into one of twice its size, to the other
side."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Lighting:
    """What a change of the light can do to mean images.

    Attributes:
        base, scenery: the camera and the light before.
        levels: lamps and channels whose level can change.
        ways: other changes of its images, each with a prior.
        means: what they do, levels first, (levels + ways, shots, channels, blocks).
        solve: from changes of block means to amounts, (levels + ways, the rest).
    """

    base: Base
    scenery: Scenery
    levels: tuple[tuple[str, int], ...]
    ways: tuple[LightWay, ...]
    means: Floats
    solve: Floats

    def amounts(self, change: Floats) -> tuple[Floats, Floats]:
        """How much of each level and of each way is in a change of block means."""
        found = np.asarray(self.solve @ change.ravel())
        return found[: len(self.levels)], found[len(self.levels) :]

    def shown(self, ways: Floats, levels: Floats | None = None) -> Floats:
        """What so much of each does to block means, (shots, channels, blocks)."""
        if levels is None:
            levels = np.zeros(len(self.levels))
        return np.tensordot(np.concatenate([levels, ways]), self.means, axes=1)

    def darker(self, base: Base, levels: Floats) -> Base:
        """A camera with so much of each level taken off its lamps."""
        for (lamp, channel), amount in zip(self.levels, levels, strict=True):
            base = base.moved(f"level:{lamp}", channel, -float(amount))
        return base

    def without(self, ways: Floats) -> Scenery:
        """The scenery with so much of each way taken off its light."""
        light = self.scenery.light
        shown = changed(light, light.falls, self.ways, -ways)
        return dataclasses.replace(self.scenery, light=shown)


def lighting(base: Base, scenery: Scenery, reference: Observation) -> Lighting | None:
    """What changes of the light can do; None where nobody stated it, or no lamp is on.

    Args:
        base: the calibrated camera.
        scenery: light and shots.
        reference: a twin of the camera.
    """
    if not scenery.light.known or all(shot.dark for shot in scenery.shots):
        return None
    levels = list(level_ways(base, scenery, reference))
    images = tuple(image_ways(base, scenery, reference))
    ways = (*(way for _, _, way in levels), *images)
    means = np.array([way.means for way in ways])
    picture = reference.means.mean(axis=0)
    noise = reference.noise[..., None] / (reference.samples * reference.frames)
    variance = noise + np.square(LIGHT_FLOOR * picture) + NOTHING_DN2
    weights = (1.0 / np.sqrt(variance)).ravel()
    priors = np.array([0.0 if way.prior == FREE else 1.0 / way.prior for way in ways])
    columns = means.reshape(len(ways), -1) * weights
    square = columns @ columns.T + np.diag(np.square(priors))
    solve = np.linalg.pinv(square, hermitian=True) @ columns * weights
    return Lighting(
        base=base,
        scenery=scenery,
        levels=tuple((lamp, channel) for lamp, channel, _ in levels),
        ways=images,
        means=means,
        solve=solve,
    )


def relit(
    how: Lighting | None,
    base: Base,
    scenery: Scenery,
    *,
    before: Sequence[Effect],
    after: Sequence[Effect],
    seed: int,
) -> tuple[Base, Scenery]:
    """The light under which effects leave pictures as they were, as far as any light can.

    Nothing is known of the level of a lamp, so that it is the camera's: mean images are held
    against stated light that is as bright. They are held against the stated shading.

    Args:
        how: what a change of the light can do; None where nothing is known of it.
        base, scenery: a camera with the effects, and the light before.
        before: what the camera of `how` has besides.
        after: what this one has; where these differ behind the light, it stays as it is.
        seed: of the body and everything random.

    Returns:
        the camera with the levels of such light, and the scenery.
    """
    if how is None or of_the_light(before) == of_the_light(after):
        return base, scenery
    as_it_was = _as_it_was(how, of_the_light(before), seed)
    given_back, response = np.zeros(len(how.ways)), 1.0
    last, aimed = None, None
    for _ in range(ROUNDS):
        change = light_means(scenery, base, effects=after, seed=seed) - as_it_was
        if last is not None and aimed is not None:
            seen = float(np.vdot(last - change, aimed) / np.vdot(aimed, aimed))
            response = float(np.clip(response * seen, *RESPONSES))
        levels, more = how.amounts(change)
        last, aimed = change, how.shown(more, levels)
        if np.abs(aimed).max() < LEAST_DN:
            break
        given_back = given_back + more / response
        base, scenery = how.darker(base, levels / response), how.without(given_back)
    return base, scenery


@functools.lru_cache(maxsize=8)
def _as_it_was(how: Lighting, before: tuple[Effect, ...], seed: int) -> Floats:
    """Block means before any change: many suspects are held against the same ones."""
    return light_means(how.scenery, how.base, effects=before, seed=seed)
