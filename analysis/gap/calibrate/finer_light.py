"""What light is like within pixels, told by a picture.

A picture that is softer than its stated light was softened where it was not made of pixels yet. Of
light whose pixels are small beside its edges that makes no difference; of a chart at 160 x 120 the
means of pixels are up to 3 DN off, beside every edge, which looks like a lens in another focus.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import get_args

import numpy as np

from analysis.gap.calibrate.refine import Refined, further, refined
from analysis.gap.calibrate.shown_picture import likeliest, picture_of
from analysis.gap.camera.base import Base
from analysis.gap.camera.blur import Within, softened
from analysis.gap.camera.light import Light
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from sensor.frames import Frames

KINDS: tuple[Within, ...] = get_args(Within)
"""Points first."""

LEAST_BLUR_PX2 = 0.02
"""Blur from which finer light is looked for: less moves no light from one pixel to the next."""

NOTHING = 0.002
"""Part of the brightest rate that finer light changes at most where it makes no difference."""

CLEARLY = 10.0
"""By which natural logarithm a picture has to be likelier: dim ones hardly tell. Of bright ones it
was 58 or more, see docs/decisions/edges-lie-somewhere-in-a-pixel.md."""

CLEAN = 1.35
"""Mean square at edges, beside that elsewhere, up to which a picture shows its light alone. Of
another engineer's cameras whose picture nothing was wrong with it was 1.13 to 1.22, of our own 0.83
to 1.04; of those with another lens, a sharpening or colours for two pixels 1.9 to 7.7."""


def with_finer_light(
    found: Refined, seen: Observation, scenery: Scenery, frames: Sequence[Frames]
) -> Refined:
    """The camera under light that is smooth or has edges within pixels, if the brightest picture is
    likelier so, and nothing else is wrong at its edges; else the same.

    Args:
        found: a camera against the frames.
        seen: the frames that fit.
        scenery: their light and shots.
        frames: of all shots.
    """
    light, base = scenery.light, found.base
    if base.within != "points" or not _may_be_finer(light, base):
        return found
    picture = picture_of(frames, light, scenery.view.lattices)
    if picture is None:
        return found
    points, *finer = (likeliest(picture, within) for within in KINDS)
    best = max(finer, key=lambda one: one.log_likelihood)
    likelier = best.log_likelihood > points.log_likelihood + CLEARLY
    narrow = best.blur.variance_px2 < LEAST_BLUR_PX2
    if not likelier or narrow or best.at_edges > CLEAN:
        return found
    other = dataclasses.replace(base, within=best.blur.within, blur_px2=best.blur.variance_px2)
    return further(refined(other, seen, scenery, found.effects), seen, scenery)


def under_other_light(base: Base, light: Light) -> list[Base]:
    """The camera under light of the other kinds, where that makes a difference.

    Args:
        base: the camera.
        light: that is stated.
    """
    if not _may_be_finer(light, base):
        return []
    others = (within for within in KINDS if within != base.within)
    return [dataclasses.replace(base, within=within) for within in others]


def _may_be_finer(light: Light, base: Base) -> bool:
    """Whether it is known what light falls on pixels, and the picture of a lamp, in its middle
    colour, is another one under light that is finer within them.
    """
    if not light.known or light.drawn or base.blur_px2 < LEAST_BLUR_PX2:
        return False
    picture = next(iter(light.falls.values()))[..., 1:2]
    points, *others = (
        softened(picture, dataclasses.replace(base.blur, within=within)).reshape(picture.shape)
        for within in KINDS
    )
    return any(np.abs(points - one).max() > NOTHING * picture.max() for one in others)
