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

from analysis.gap.calibrate.refine import WORTH_A_STEP, Refined, further, refined
from analysis.gap.calibrate.shown_picture import likeliest, picture_of
from analysis.gap.camera.base import Base
from analysis.gap.camera.blur import Within, softened
from analysis.gap.camera.light import Light
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from sensor.frames import Frames

LEAST_BLUR_PX2 = 0.02
"""Blur from which finer light is looked for: less moves no light from one pixel to the next."""

NOTHING = 0.002
"""Part of the brightest rate that finer light changes at most where it makes no difference."""

CLEAN = 1.35
"""Mean square at edges, beside that elsewhere, up to which a picture shows its light alone. Of two
engineers' cameras without a fault in the picture it was 1.13 to 1.22, of our own 0.83 to 1.04; of
those with another lens, a sharpening or another codec 1.9 to 7.7."""


def with_finer_light(
    found: Refined, seen: Observation, scenery: Scenery, frames: Sequence[Frames]
) -> Refined:
    """The camera under light that is smooth or has edges within pixels, if the brightest picture is
    likelier so; else the same. Where something else is wrong at its edges twins have to say so too,
    by as much as a step of a calibration is worth.

    Args:
        found: a camera against the frames.
        seen: the frames that fit.
        scenery: their light and shots.
        frames: of all shots.
    """
    light, base = scenery.light, found.base
    told = light.known and not light.drawn and base.blur_px2 >= LEAST_BLUR_PX2
    if not told or base.within != "points" or not _matters(light, base):
        return found
    picture = picture_of(frames, light, scenery.view.lattices)
    if picture is None:
        return found
    kinds: tuple[Within, ...] = get_args(Within)
    best = max((likeliest(picture, within) for within in kinds), key=lambda one: one.log_likelihood)
    if best.blur.within == base.within or best.blur.variance_px2 < LEAST_BLUR_PX2:
        return found
    other = dataclasses.replace(base, within=best.blur.within, blur_px2=best.blur.variance_px2)
    under_it = further(refined(other, seen, scenery, found.effects), seen, scenery)
    likelier = under_it.deviance < found.deviance - WORTH_A_STEP
    return under_it if best.at_edges < CLEAN or likelier else found


def _matters(light: Light, base: Base) -> bool:
    """Whether the picture of a lamp is another one under finer light, in its middle colour."""
    picture = next(iter(light.falls.values()))[..., 1:2]
    points, *others = (
        softened(picture, dataclasses.replace(base.blur, within=within)).reshape(picture.shape)
        for within in get_args(Within)
    )
    return any(np.abs(points - one).max() > NOTHING * picture.max() for one in others)
