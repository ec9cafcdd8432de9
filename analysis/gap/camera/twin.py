"""The twin: what a simulated camera would have shown of the same shots."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.gap.camera.base import Base, Body, camera_of
from analysis.gap.camera.light import Light, Rate, lamp_of, level_of, single
from analysis.gap.camera.light_blocks import light_noise
from analysis.gap.look.observe import Observation, Stack, View, observe
from analysis.gap.look.repeats import fresh, repeats
from sensor.camera import Camera
from sensor.effect import Effect
from sensor.protocol import Shot
from sensor.simulation import pixels_of, simulate


@dataclass(frozen=True, kw_only=True, eq=False)
class Scenery:
    """Everything of a capture that is not the camera's noise.

    Attributes:
        body: format of the frames.
        light: what falls on the sensor.
        shots: the shots that are simulated, each under one lamp of the light.
        view: how they are looked at.
        rules: ways of counting of its demosaicer that the frames leave open; see `rules_of`.
    """

    body: Body
    light: Light
    shots: tuple[Shot, ...]
    view: View
    rules: tuple[int, ...]

    def only(self, labels: Sequence[str]) -> Scenery:
        """The same with some of the shots."""
        return dataclasses.replace(
            self, shots=tuple(shot for shot in self.shots if shot.label in labels)
        )


def twin(
    scenery: Scenery,
    base: Base,
    *,
    effects: Sequence[Effect] = (),
    seed: int = 0,
    body: int | None = None,
) -> Observation:
    """One simulated capture, a group of frames of each shot, looked at.

    The same seed gives the same random numbers, so that two twins differ by what is different in
    their cameras. Each seed is a camera body of its own, unless a body is named.

    Args:
        scenery: light, shots, and how to look.
        base: the calibrated camera.
        effects: what it has besides.
        seed: of everything random.
        body: seed of what is fixed in the camera and of its light.
    """
    body = seed if body is None else body
    camera = camera_of(base, scenery.body).plus(*effects).with_body(body)
    lit = electrons(base, scenery.light.rates)
    seen = observe(_stacks(camera, scenery, lit, seed), scenery.view)
    return _under_noisy_light(seen, scenery, base, body) if scenery.light.noise else seen


def _under_noisy_light(seen: Observation, scenery: Scenery, base: Base, body: int) -> Observation:
    """The twin as if its light had been traced with other paths than ours."""
    draw = np.random.default_rng(body)
    errors = {
        lamp: np.sqrt(variance) * draw.standard_normal(variance.shape)
        for lamp, variance in light_noise(scenery.light, scenery.view, seen.channels).items()
    }
    means = seen.means.copy()
    for k, shot in enumerate(scenery.shots):
        if not shot.dark and lamp_of(shot) in errors:
            above = np.maximum(means[:, k] - base.black_dn[:, None], 0.0)
            means[:, k] += above * errors[lamp_of(shot)]
    return dataclasses.replace(seen, means=means)


def electrons(base: Base, rates: Mapping[str, Rate]) -> dict[str, Rate]:
    """The light in electrons per second of the calibrated camera."""
    by_colour = {}
    for lamp, rate in rates.items():
        level = base.level[lamp]
        by_colour[lamp] = softened(rate, base.blur_px2) * np.asarray(
            np.repeat(level, 3) if len(level) == 1 else level, dtype=np.float32
        )
    return by_colour


def softened(rate: Rate, variance_px2: float) -> Rate:
    """A picture convolved with a normal distribution of that variance along each axis."""
    if variance_px2 <= 0:
        return rate
    import cv2

    sigma_px = float(np.sqrt(variance_px2))
    return np.asarray(cv2.GaussianBlur(rate, (0, 0), sigma_px, borderType=cv2.BORDER_REFLECT_101))


MORE = 4
"""Groups of frames that show how many repeat: up to half of them do."""


def _stacks(
    camera: Camera, scenery: Scenery, rates: Mapping[str, Rate], seed: int
) -> Iterator[Stack]:
    """One group of frames of each shot; of a camera that repeats some, out of many more."""
    wanted = scenery.view.frames
    some_repeat = any(effect.repeats for effect in camera.effects)
    frames = range(MORE * wanted if some_repeat else wanted)
    for shot in scenery.shots:
        dn = pixels_of(camera, simulate(camera, shot, rates, seed=seed, frames=frames))
        yield Stack(
            label=shot.label,
            lit=not shot.dark,
            groups=[fresh(dn, wanted)],
            repeated=float(repeats(dn).mean()),
        )


def shots_of(shots: Sequence[Shot]) -> tuple[Shot, ...]:
    """Shots under one lamp each; see `light.single`."""
    return tuple(single(shot) for shot in shots)


def exposure_of(shot: Shot) -> float:
    """Exposure times level: what the light of a lamp is multiplied by."""
    return shot.exposure_s * level_of(shot)
