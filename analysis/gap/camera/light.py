"""The light that falls on the sensor in a capture: rate images by lamp.

Where the rate image is stated it is taken, where the scene is it is rendered. Otherwise the light
is read from the frames: a smooth surface through pictures that are even, so that what is left of
them can be judged; or else what they show, and only what differs between shots of one lamp can.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.camera.grey_light import GREEN, Picture, in_green, sum_seen
from analysis.gap.camera.light_of_frames import clear, light_shown, plane, without_pattern
from analysis.gap.camera.surface import surface_of
from foundation.panel import Panel
from render import path_traced
from render.rate import RateImage
from scenes import scene as scenes
from sensor.errors import CaptureError
from sensor.frames import Capture, Frames
from sensor.protocol import DARK, Shot

Rate = NDArray[np.float32]

PATHS = 32
"""Light paths per pixel of a rendered scene of usual size: 2e-4 of the light inside panels. Where
patches meet it is a hundred times that, which is counted; see `Light.noise`."""

USUAL_PX = 640 * 480
"""Pixels of a picture that gets `PATHS`."""

MOST_TIMES = 4
"""Smaller pictures get so many times the paths: fewer pixels average them."""

LEAST_CLEAR = 0.1
"""Part of the pixels that tell whether a picture shows a scene."""

LEAST_SEEN_DN = 4.0
"""Mean above black of a picture that does."""

LEAST_CONTRAST = 0.02
"""The same of its light: standard deviation over the mean."""

LEAST_CORRELATION = 0.8
"""Between the frames of a lamp that show it best and its light; a scene that shows less is another.
"""


@dataclass(frozen=True, kw_only=True, eq=False)
class Light:
    """The light of a capture.

    Attributes:
        rates: photo-electrons per second at level 1 by lamp, (H, W, 3); in arbitrary units where
            it was read from the frames.
        noise: variance of these from the finite number of light paths, ours and those of a capture
            that was simulated: all of it may be there, or none. Empty where the very light is
            stated.
        panels: areas of one reflectance.
        known: whether pictures can be judged by it.
        source: in words.
        in_electrons: whether it comes from outside of the frames.
        shown: the rates as the frames show them, where that is known: shading and reflectances are
            never quite as they were stated.
    """

    rates: Mapping[str, Rate]
    noise: Mapping[str, Rate]
    panels: tuple[Panel, ...]
    known: bool
    source: str
    in_electrons: bool = True
    shown: Mapping[str, Rate] | None = None

    @property
    def falls(self) -> Mapping[str, Rate]:
        """The rates by which twins are lit."""
        return self.rates if self.shown is None else self.shown

    @property
    def drawn(self) -> bool:
        """Whether it is a surface through the frames."""
        return self.known and not self.in_electrons

    @property
    def lamps(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.rates)


def lamp_of(shot: Shot) -> str:
    """One name for what lights a shot; several lamps together count as a lamp of their own."""
    if len(shot.light) == 1:
        return shot.light[0]
    return "+".join(f"{lamp}x{level:g}" for lamp, level in zip(shot.light, shot.level, strict=True))


def level_of(shot: Shot) -> float:
    """Level of that lamp."""
    return shot.level[0] if len(shot.light) == 1 else 1.0


def single(shot: Shot) -> Shot:
    """The shot as lit by that one lamp."""
    if shot.dark:
        return dataclasses.replace(shot, light=(DARK,), level=(1.0,))
    return dataclasses.replace(shot, light=(lamp_of(shot),), level=(level_of(shot),))


def light_of(capture: Capture, stated: Mapping[str, RateImage], black_dn: float) -> Light:
    """The light of a capture.

    Args:
        capture: the frames.
        stated: rate images that came with it, by lamp.
        black_dn: pixel value without light.

    Raises:
        InputError: for a scene that is none, has no such lamp, or is not in the frames.
    """
    lit = [f for f in capture.frames if not f.shot.dark]
    names = dict.fromkeys(name for f in lit for name in f.shot.light if name != DARK)
    height, width = capture.frames[0].height, capture.frames[0].width
    images = {name: image for name, image in stated.items() if name in names}
    source = "the rate images of the capture"
    rendered = set(names) - set(images)
    paths = PATHS * int(np.clip(USUAL_PX / (height * width), 1, MOST_TIMES))
    if capture.scene is not None and set(names) - set(images):
        scene = scenes.load(capture.scene).with_size(width, height)
        for name in rendered:
            images[name] = path_traced.render(scene, scene.named(name), samples=paths)
        source = f"scene '{capture.scene}'"
    if names and not set(names) - set(images):
        light = _known(lit, images, rendered, 1 + paths / PATHS, source)
        if capture.channels == ("Y",):
            light = _in_grey(light, lit, black_dn)
        _refuse_another_scene(capture, light, black_dn)
        return light
    averaged = {lamp: light_shown(shots, black_dn) for lamp, shots in _by_lamp(lit).items()}
    surfaces = {lamp: surface_of(image) for lamp, image in averaged.items()}
    even = {lamp: rate for lamp, rate in surfaces.items() if rate is not None}
    if len(even) == len(averaged) > 0:
        return Light(
            rates=even,
            noise={},
            panels=(),
            known=True,
            in_electrons=False,
            source="a surface through the even pictures of the frames",
        )
    return Light(
        rates={lamp: without_pattern(image) for lamp, image in averaged.items()},
        noise={},
        panels=(),
        known=False,
        in_electrons=False,
        source="the frames themselves",
    )


def _known(
    lit: list[Frames],
    images: Mapping[str, RateImage],
    rendered: Collection[str],
    noisier: float,
    source: str,
) -> Light:
    """Light from rate images; those that we rendered may be so many times as uncertain as ours."""
    rates: dict[str, Rate] = {}
    noise: dict[str, Rate] = {}
    for f in lit:
        if len(f.shot.light) == 1:
            parts = [(np.float32(1.0), f.shot.light[0])]
        else:
            parts = [(np.float32(level), name)
                     for name, level in zip(f.shot.light, f.shot.level, strict=True)]  # fmt: skip
        lamp = lamp_of(f.shot)
        rates[lamp] = _sum([level * images[name].rate_e_per_s for level, name in parts])
        unsure = [
            np.float32(noisier) * level**2 * images[name].variance
            for level, name in parts
            if name in rendered
        ]
        if unsure:
            noise[lamp] = _sum(unsure)
    first = next(iter(images.values()))
    return Light(
        rates=rates,
        noise=noise,
        panels=first.header.panels,
        known=True,
        source=source,
    )


def _sum(images: list[Rate]) -> Rate:
    return np.asarray(np.sum(images, axis=0), dtype=np.float32)


def _in_grey(light: Light, lit: list[Frames], black_dn: float) -> Light:
    """The light as a camera without filters sees it: by the brightest clear shot of each lamp."""
    pictures: dict[str, tuple[float, Picture]] = {}
    for f in lit:
        rate = light.rates[lamp_of(f.shot)]
        if rate.shape[:2] != (f.height, f.width):
            continue
        seen, expected = _blurred(plane(f, black_dn)[..., 1]), _blurred(rate)
        unclipped = clear(seen, f, black_dn)
        if unclipped.mean() < LEAST_CLEAR:
            continue
        bright = float(seen[unclipped].mean())
        if bright > pictures.get(lamp_of(f.shot), (LEAST_SEEN_DN, None))[0]:
            found = Picture(seen=seen[unclipped], rate=expected[unclipped])
            pictures[lamp_of(f.shot)] = bright, found
    seen_sum = sum_seen([picture for _, picture in pictures.values()])
    if seen_sum == GREEN:
        return light
    weights = seen_sum.weights
    of_variances = [weight**2 for weight in weights]
    rates = {lamp: in_green(rate, weights) for lamp, rate in light.rates.items()}
    noise = {lamp: in_green(unsure, of_variances) for lamp, unsure in light.noise.items()}
    source = f"{light.source}, {seen_sum.name}"
    return dataclasses.replace(light, rates=rates, noise=noise, source=source)


def _blurred(picture: Rate) -> Rate:
    """Means of 4 x 4 pixels."""
    size = (4, 4) + (1,) * (picture.ndim - 2)
    return np.asarray(ndimage.uniform_filter(picture, size)[::4, ::4])


def _refuse_another_scene(capture: Capture, light: Light, black_dn: float) -> None:
    """By the shot of each lamp that shows its scene best: full photosites hide it."""
    best: dict[str, tuple[float, str]] = {}
    for f in capture.lit:
        lamp = lamp_of(f.shot)
        rate = light.rates[lamp]
        if rate.shape[:2] != (f.height, f.width):
            raise CaptureError(
                f"the rate image of shot '{f.shot.label}' has"
                f" {rate.shape[1]} x {rate.shape[0]} pixels",
                f"expected {f.width} x {f.height} as its frames have",
                "correct 'rate', or leave it out",
            )
        seen, expected = _blurred(plane(f, black_dn)[..., 1]), _blurred(rate[..., 1])
        likeness = _likeness(seen, expected, clear(seen, f, black_dn))
        if likeness is not None:
            best[lamp] = max(best.get(lamp, (-1.0, "")), (likeness, f.shot.label))
    for found, label in best.values():
        if found < LEAST_CORRELATION:
            raise CaptureError(
                f"the frames of shot '{label}' do not show {light.source}"
                f" (correlation {found:.2f})",
                f"expected at least {LEAST_CORRELATION}",
                "correct 'scene' or 'rate' in the manifest, or leave them out",
            )


def _likeness(seen: Rate, expected: Rate, unclipped: NDArray[np.bool_]) -> float | None:
    """Correlation of a picture with its light where it is clear; None where that tells nothing."""
    seen, expected = seen[unclipped], expected[unclipped]
    tells = unclipped.mean() >= LEAST_CLEAR and seen.mean() > LEAST_SEEN_DN
    if not tells or seen.std() == 0 or expected.std() < LEAST_CONTRAST * expected.mean():
        return None
    return float(np.corrcoef(seen, expected)[0, 1])


def _by_lamp(lit: list[Frames]) -> dict[str, list[tuple[float, Frames]]]:
    """Shots of each lamp with how much light they had, in seconds at level 1."""
    shots: dict[str, list[tuple[float, Frames]]] = {}
    for f in lit:
        unit = max(level_of(f.shot) * f.shot.exposure_s, 1e-9)
        shots.setdefault(lamp_of(f.shot), []).append((unit, f))
    return shots
