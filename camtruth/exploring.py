"""What each effect of the catalogue does to the frames of a camera, at several strengths."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.measure.signature import scaled, starts
from foundation.errors import InputError
from render.closed_form import render
from scenes.scene import Scene
from sensor.camera import Camera
from sensor.effect import Effect
from sensor.protocol import DARK, Shot
from sensor.simulation import pixels_of, simulate

WIDTH, HEIGHT, FRAMES = 128, 96, 24
EXPOSURE_S, INTERVAL_S, TEMPERATURE_C = 0.03268, 0.0667, 29.0
FACTORS = (0.25, 1.0, 2.0, 4.0, 8.0)
"""Strengths, as parts of the default."""

FILLED = 0.85
"""Part of the range that the brightest pixel has."""

Rates = Mapping[str, NDArray[np.float32]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Pair:
    """Frames of one shot without an effect and with it, by the same random numbers.

    Attributes:
        without, with_it: in DN, (N, H, W) or (N, H, W, 3).
    """

    without: NDArray[Any]
    with_it: NDArray[Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class State:
    """An effect with its parameters, and what it does.

    Attributes:
        effect: with its parameters.
        lit, dark: frames of the chart, and of darkness.
    """

    effect: Effect
    lit: Pair
    dark: Pair


def strengths_of(kind: type[Effect]) -> list[Effect]:
    """An effect at several strengths, weakest first, or with each of its choices."""
    made = list(dict.fromkeys(scaled(kind(), factor) for factor in FACTORS))
    return made if len(made) > 1 else list(dict.fromkeys(starts(kind)))


def states(
    camera: Camera, scene: Scene, lamp: str, kinds: Iterable[type[Effect]], seed: int
) -> Iterator[State]:
    """Every effect that this camera can have, at every strength.

    Args:
        camera: without the effects.
        scene: what it sees.
        lamp: its light.
        kinds: the effects.
        seed: of everything random; the same in all states.
    """
    small = camera.resized(HEIGHT, WIDTH)
    rate = render(scene.with_size(WIDTH, HEIGHT), lamp).rate_e_per_s
    fill = FILLED * (2**small.bits - 1) - small.black_dn
    brightest = float((rate * EXPOSURE_S * np.array(list(small.gain_dn_per_e))).max())
    rates = {lamp: np.asarray(rate * (fill / brightest), np.float32)}
    shots = [_shot("lit", (lamp,)), _shot("dark", (DARK,))]
    without = [_frames(small, shot, rates, seed) for shot in shots]
    for kind in kinds:
        for effect in strengths_of(kind):
            try:
                seen = [_frames(small.plus(effect), shot, rates, seed) for shot in shots]
            except InputError:
                continue  # a camera without colours has no matrix of them
            lit, dark = (Pair(without=a, with_it=b) for a, b in zip(without, seen, strict=True))
            yield State(effect=effect, lit=lit, dark=dark)


def _shot(label: str, light: tuple[str, ...]) -> Shot:
    return Shot(
        label=label,
        light=light,
        level=(1.0,),
        exposure_s=EXPOSURE_S,
        frames=FRAMES,
        interval_s=INTERVAL_S,
        temperature_c=TEMPERATURE_C,
    )


def _frames(camera: Camera, shot: Shot, rates: Rates, seed: int) -> NDArray[Any]:
    return pixels_of(camera, simulate(camera, shot, rates, seed=seed))
