"""What light is like within pixels, told by which twins fit.

A picture that is softer than its stated light was softened where it was not made of pixels yet. Of
light whose pixels are small beside its edges that makes no difference; of a chart at 160 x 120 the
means of pixels are up to 3 DN off, beside every edge, which looks like a lens in another focus.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.gap.calibrate.refine import WORTH_A_STEP, Refined, further, refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.blur import Within, softened
from analysis.gap.camera.light import Light
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation

FINER: tuple[Within, ...] = ("smooth", "edges")

LEAST_BLUR_PX2 = 0.02
"""Blur from which finer light is looked for: less moves no light from one pixel to the next."""

PARTS = (1.0, 0.8)
"""Parts of a blur of points that one of finer light may have: with edges it is 1.0 of that of the
chart behind a blur of 0.6 px, and 0.8 of that of patches with hard edges; of smooth light behind
0.5 px it is 0.85."""

NOTHING = 0.002
"""Part of the brightest rate that finer light changes at most where it makes no difference."""


def with_finer_light(found: Refined, seen: Observation, scenery: Scenery) -> Refined:
    """The camera under light that is smooth or has edges within pixels, if that is likelier by as
    much as a step of a calibration is worth; else the same.

    Args:
        found: a camera against the frames.
        seen: the frames that fit.
        scenery: their light and shots.
    """
    light, base = scenery.light, found.base
    told = light.known and not light.drawn and base.blur_px2 >= LEAST_BLUR_PX2
    if not told or base.within != "points":
        return found
    others = [
        dataclasses.replace(base, within=within, blur_px2=part * base.blur_px2)
        for within in FINER
        if _matters(light, base, within)
        for part in PARTS
    ]
    against = [refined(other, seen, scenery, found.effects) for other in others]
    best = min(against, key=lambda one: one.deviance, default=found)
    if not _likelier(best, found):
        return found
    best, found = (further(one, seen, scenery) for one in (best, found))
    return best if _likelier(best, found) else found


def _likelier(one: Refined, other: Refined) -> bool:
    return one.deviance < other.deviance - WORTH_A_STEP


def _matters(light: Light, base: Base, within: Within) -> bool:
    """Whether the picture of a lamp is another one under finer light, in its middle colour."""
    picture = next(iter(light.falls.values()))[..., 1:2]
    points, finer = (
        softened(picture, dataclasses.replace(base.blur, within=one)).reshape(picture.shape)
        for one in (base.within, within)
    )
    return bool(np.abs(points - finer).max() > NOTHING * picture.max())
