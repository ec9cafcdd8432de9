"""The twin: what a simulated camera would have shown of the same shots."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base, Body, camera_of
from analysis.gap.camera.blur import Blur, softened
from analysis.gap.camera.light import Light, Rate, lamp_of, level_of, single
from analysis.gap.camera.light_blocks import beyond_stated, light_noise
from analysis.gap.look.arithmetic import FINER
from analysis.gap.look.observation import Observation, Stack, View
from analysis.gap.look.observe import begun
from analysis.gap.look.repeats import fresh, partly_repeats, repeats
from analysis.gap.look.statistics.greens import APART, apart
from foundation.backend import Backend, backend
from sensor.camera import Camera
from sensor.effect import Effect, Stage
from sensor.effects.demosaic_other import DemosaicOther
from sensor.effects.quantization import Quantization
from sensor.protocol import Shot
from sensor.signal import Signal
from sensor.simulation import exposed, lit, pixels_of

Floats = NDArray[np.float64]


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
        """The scenery with the shots of these labels alone, in the order that they have here."""
        return dataclasses.replace(
            self, shots=tuple(shot for shot in self.shots if shot.label in labels)
        )


def begun_twin(
    scenery: Scenery,
    base: Base,
    *,
    effects: Sequence[Effect] = (),
    seed: int = 0,
    body: int | None = None,
) -> Callable[[], Observation]:
    """One simulated capture, a group of frames of each shot, begun to be looked at.

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
    bare = camera_of(base, scenery.body)
    lights = lights_of(scenery, base, bare)
    told = base.arithmetic in FINER
    camera = halves_either_way(bare.plus(*effects), effects, body, told=told).with_body(body)
    look = begun(_stacks(camera, lights, scenery.view.frames, seed), scenery.view)
    return functools.partial(_under_its_light, look, scenery, base, body)


def halves_either_way(
    camera: Camera, effects: Sequence[Effect], body: int, *, told: bool = False
) -> Camera:
    """The camera with halves of codes that go up in every other body, where colours are weighed.

    What processes whole codes by weights of its own leaves many sums half way between two codes,
    and the order of additions, which nobody knows, says which way they go. Measured samples pass
    another demosaicer as they are: theirs go where a camera with finer steps sends all halves.

    Args:
        camera: with the effects.
        effects: what it has besides its base.
        body: of which camera.
        told: whether the frames tell where halves of measured samples go.
    """
    weighing = [e for e in effects if e.stage is Stage.PROCESSING]
    if all(told and isinstance(effect, DemosaicOther) for effect in weighing):
        return camera
    counted = next((e for e in camera.effects if isinstance(e, Quantization)), None)
    if counted is None:
        return camera
    return camera.plus(dataclasses.replace(counted, halves=1.0 if body % 2 else -1.0))


def _under_its_light(
    look: Callable[[], Observation], scenery: Scenery, base: Base, body: int
) -> Observation:
    """A twin as soon as all of it was looked at, with what its light is not known by."""
    seen = look()
    if scenery.light.shown is not None:
        seen = under_stated_light(seen, scenery, base)
    return under_noisy_light(seen, scenery, base, body) if scenery.light.noise else seen


NOT_CLIPPED = 0.97
"""Part of the range up to which the mean of a block tells how bright it is."""


def under_stated_light(seen: Observation, scenery: Scenery, base: Base) -> Observation:
    """A twin under light as the frames show it, with the mean images of the stated light.

    A hundredth of the light moves patches of a chart by a code, and their histogram is another. How
    far the light of a capture is from what was stated is told by its mean images alone.
    """
    light, view = scenery.light, scenery.view
    means = seen.means.copy()
    for k, shot in enumerate(scenery.shots):
        if shot.dark:
            continue
        lamp = lamp_of(shot)
        more = beyond_stated(light, view, seen.channels, lamp)
        dn = (base.level[lamp] * base.gain_dn_per_e)[:, None] * more * exposure_of(shot)
        means[:, k] -= np.where(means[:, k] < NOT_CLIPPED * view.top_dn, dn, 0.0)
    return dataclasses.replace(seen, means=means)


def under_noisy_light(seen: Observation, scenery: Scenery, base: Base, body: int) -> Observation:
    """The twin as if its light had been traced with other paths than ours, with endlessly many, as
    that of a real scene, or with the very same.
    """
    draw = np.random.default_rng(body)
    light = scenery.light
    part = draw.uniform()
    errors, of_greens = {}, {}
    for lamp, variance in light_noise(light, scenery.view, seen.channels).items():
        sd = np.sqrt(part * variance)
        errors[lamp] = sd * draw.standard_normal(variance.shape)
        # the mean of two greens has half the error of their difference
        of_greens[lamp] = 2.0 * sd[len(sd) // 2] * draw.standard_normal(variance.shape[1])
    means, figures = seen.means.copy(), seen.figures.copy()
    places = {(key.shot, key.statistic): place for place, key in enumerate(seen.keys)}
    for k, shot in enumerate(scenery.shots):
        lamp = lamp_of(shot)
        if shot.dark or lamp not in errors:
            continue
        above = np.maximum(means[:, k] - base.black_dn[:, None], 0.0)
        means[:, k] += above * errors[lamp]
        if (shot.label, APART) not in places:
            continue
        for group, (red, green, blue) in enumerate(above):
            for name, error in apart(green * of_greens[lamp], green, red - blue).items():
                figures[group, places[shot.label, name]] += error
    return dataclasses.replace(seen, means=means, figures=figures)


KEPT_SHOTS = 16
"""Shots whose light is kept on the backend: many twins differ in effects alone."""


def lights_of(scenery: Scenery, base: Base, bare: Camera) -> list[Signal]:
    """The light of each shot before the first effect.

    Args:
        scenery: light and shots.
        base: the calibrated camera.
        bare: the same as a camera without any other effect; see `camera_of`.
    """
    level, where = _kept_by(base.level), backend()
    return [_lit(scenery.light, base.blur, level, bare, shot, where) for shot in scenery.shots]


def electrons(light: Light, blur: Blur, level: Mapping[str, Floats]) -> dict[str, Rate]:
    """The light in electrons per second of a calibrated camera; `level` and `blur` are its."""
    return _electrons(light, blur, _kept_by(level))


_Level = tuple[tuple[str, tuple[float, ...]], ...]
"""Levels by lamp, by which what is made of them can be kept."""


def _kept_by(level: Mapping[str, Floats]) -> _Level:
    return tuple((lamp, tuple(figures.tolist())) for lamp, figures in level.items())


@functools.lru_cache(maxsize=KEPT_SHOTS)
def _lit(
    light: Light,
    blur: Blur,
    level: _Level,
    bare: Camera,
    shot: Shot,
    where: Backend,
) -> Signal:
    """The light of a shot before the first effect."""
    return lit(bare, shot, _electrons(light, blur, level), where)


@functools.lru_cache(maxsize=4)
def _electrons(light: Light, blur: Blur, level: _Level) -> dict[str, Rate]:
    soft = _soft(light, blur)
    return {lamp: soft[lamp] * np.array(figures, np.float32) for lamp, figures in level}


@functools.lru_cache(maxsize=4)
def _soft(light: Light, blur: Blur) -> dict[str, Rate]:
    return {lamp: softened(rate, blur) for lamp, rate in light.falls.items()}


MORE = 4
"""Groups of frames that show how many repeat: up to half of them do."""


def _stacks(camera: Camera, lights: Sequence[Signal], wanted: int, seed: int) -> Iterator[Stack]:
    """One group of frames of each shot; of a camera that repeats some, out of many more."""
    some_repeat = any(effect.repeats for effect in camera.effects)
    frames = range(MORE * wanted if some_repeat else wanted)
    for light in lights:
        dn = pixels_of(camera, exposed(camera, light, frames, seed=seed))
        yield Stack(
            label=light.shot.label,
            lit=not light.shot.dark,
            groups=[fresh(dn, wanted)],
            counted=len(dn),
            repeated=int(repeats(dn).sum()),
            in_part=int(partly_repeats(dn).sum()),
        )


def shots_of(shots: Sequence[Shot]) -> tuple[Shot, ...]:
    """Shots under one lamp each; see `light.single`."""
    return tuple(single(shot) for shot in shots)


def exposure_of(shot: Shot) -> float:
    """Exposure times level: what the light of a lamp is multiplied by."""
    return shot.exposure_s * level_of(shot)
