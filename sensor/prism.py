"""Three sensors behind a prism: every pixel is measured in all three colours, none is filled in."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from sensor.camera import GREY, Camera
from sensor.colours import CHANNELS
from sensor.effect import Effect
from sensor.effects.demosaic import Demosaic
from sensor.planes import Planes
from sensor.signal import Quantity, Signal
from sensor.stream import key_of


def sensors(camera: Camera) -> dict[str, Camera]:
    """Each sensor of a camera that has three, by its colour: a camera of its own, with patterns of
    its own, that sees one colour in every pixel. The optics are the camera's.
    """
    _, own, _ = parts(camera.chain)
    return {
        colour: dataclasses.replace(
            camera,
            cfa=colour * len(GREY),
            pixels="mono16",
            effects=own,
            body_seed=key_of(camera.body_seed, colour),
        )
        for colour in CHANNELS
    }


def parts(
    chain: Sequence[Effect],
) -> tuple[tuple[Effect, ...], tuple[Effect, ...], tuple[Effect, ...]]:
    """Effects in front of the prism, those that each sensor has, and those behind all three."""
    before = tuple(e for e in chain if e.quantity() is Quantity.RATE)
    after = tuple(e for e in chain if e.place() > Demosaic.place())
    own = tuple(e for e in chain if e not in before and e not in after)
    return before, own, after


def joined(seen: Sequence[Signal], camera: Camera) -> Signal:
    """What three sensors have seen as one signal of three colours, (f, H, W, 3)."""
    first = seen[0]
    planes = [one.planes for one in seen]
    made = Planes(
        colours=tuple(colour for one in planes for colour in one.colours),
        shape=(*first.shape, len(CHANNELS)),
        arrays=first.backend.arrays,
    )
    return first.replace(made, format=camera.format)
