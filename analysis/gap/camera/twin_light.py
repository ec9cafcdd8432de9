"""The light of a twin and its dark current, as mean images would show them without noise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base, camera_of
from analysis.gap.camera.light_blocks import blocks_of
from analysis.gap.camera.twin import Scenery, lights_of
from sensor.effect import Effect
from sensor.signal import Quantity, Signal
from sensor.simulation import exposed

Floats = NDArray[np.float64]


def of_the_light(effects: Iterable[Effect]) -> tuple[Effect, ...]:
    """The effects that act on light, before it is charge, in their order."""
    return tuple(effect for effect in effects if effect.quantity() is Quantity.RATE)


def light_means(
    scenery: Scenery, base: Base, *, effects: Sequence[Effect] = (), seed: int = 0
) -> Floats:
    """Block means of one twin in DN, as far as light, black level and dark current make them,
    (shots, channels, blocks).

    What other effects do is left out, clipping as well, and so is most of the time that a twin
    takes: no noise is drawn, and light that is the same in all frames is looked at once.

    Args:
        scenery: light and shots; those in the dark are nought.
        base: the calibrated camera.
        effects: what it has besides, of which those of the light are looked at.
        seed: of everything random, and of the body.
    """
    bare = camera_of(base, scenery.body)
    camera = bare.plus(*of_the_light(effects)).with_body(seed)
    frames = range(scenery.view.frames)

    def picture(light: Signal) -> Floats:
        seen = exposed(camera, light, frames, seed=seed, until=Quantity.RATE)
        rate = np.asarray(seen.value.numpy()).mean(axis=0)
        e_per_s = blocks_of(rate, scenery.view, base.channels) + base.shown_e_per_s
        e = e_per_s * light.shot.exposure_s
        return base.gain_dn_per_e[:, None] * e + base.black_dn[:, None]

    lights = lights_of(scenery, base, bare)
    pictures = {light.shot.label: picture(light) for light in lights if not light.shot.dark}
    none = np.zeros_like(next(iter(pictures.values())))
    return np.array([pictures.get(light.shot.label, none) for light in lights])
