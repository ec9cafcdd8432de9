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
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.space import LIGHT_FLOOR
from analysis.gap.camera.base import Base
from analysis.gap.camera.light_ways import FREE, LightWay, changed, level_ways, light_ways
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from sensor.effect import Effect
from sensor.signal import Quantity

Floats = NDArray[np.float64]

LEAST_DN = 0.3
"""Change of the light, where it is largest, from which twins are lit anew: a third of a code."""

NOTHING_DN2 = 1e-9
"""Variance of a block that is black and without noise."""

ROUNDS = 2
"""Times that the light is read anew: what an effect takes off is a part of what it is given, and
the error of a round is the square of the one before."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Lighting:
    """What a change of the light can do to mean images.

    Attributes:
        scenery: the light before.
        ways: its changes, each with a prior.
        means: what they do, (ways, shots * channels * blocks).
        solve: from changes of block means to amounts, (ways, the same).
    """

    scenery: Scenery
    ways: tuple[LightWay, ...]
    means: Floats
    solve: Floats

    def amounts(self, change: Floats) -> Floats:
        """How much of each way is in a change of block means, (shots, channels, blocks)."""
        return np.asarray(self.solve @ change.ravel())

    def apart_dn(self, one: Floats, other: Floats) -> float:
        """How far two changes of the light are apart at most, in DN, by their amounts."""
        return float(np.abs((one - other) @ self.means).max(initial=0.0))

    def without(self, amounts: Floats) -> Scenery:
        """The scenery with so much of each way taken off its light."""
        light = self.scenery.light
        shown = changed(light, light.falls, self.ways, -amounts)
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
    ways = (*level_ways(base, scenery, reference), *light_ways(base, scenery, reference))
    means = np.array([way.means.ravel() for way in ways])
    picture = reference.means.mean(axis=0)
    noise = reference.noise[..., None] / (reference.samples * reference.frames)
    variance = noise + np.square(LIGHT_FLOOR * picture) + NOTHING_DN2
    weights = 1.0 / np.sqrt(variance).ravel()
    priors = np.array([0.0 if way.prior == FREE else 1.0 / way.prior for way in ways])
    columns = means * weights
    square = columns @ columns.T + np.diag(np.square(priors))
    solve = np.linalg.pinv(square, hermitian=True) @ columns * weights
    return Lighting(scenery=scenery, ways=ways, means=means, solve=solve)


def relit(
    effect: Effect,
    how: Lighting | None,
    scenery: Scenery,
    before: Observation,
    seen: Observation,
    seen_under: Callable[[Scenery], Observation],
) -> tuple[Scenery, Observation]:
    """The light under which an effect leaves pictures as they were, as far as any light can.

    Args:
        effect: one that acts behind the light leaves it as it is.
        how: what a change of the light can do.
        scenery: the light before.
        before: a twin without the effect.
        seen: the twin with it, of the same random numbers.
        seen_under: the same under some other light.
    """
    if how is None or effect.quantity() is not Quantity.RATE:
        return scenery, seen
    given_back = np.zeros(len(how.ways))
    for _ in range(ROUNDS):
        amounts = how.amounts((seen.means - before.means).mean(axis=0))
        if how.apart_dn(amounts, given_back) < LEAST_DN:
            break
        scenery, given_back = how.without(amounts), amounts
        seen = seen_under(scenery)
    return scenery, seen
