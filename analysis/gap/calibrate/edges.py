"""Light with edges within pixels, told by which twins fit.

A picture that is softer than its stated light was softened where it was not made of pixels yet. Of
light whose pixels are small beside its edges that makes no difference; of a chart at 160 x 120 the
means of pixels are up to 3 DN off, beside every edge, which looks like a lens in another focus.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from analysis.gap.calibrate.refine import WORTH_A_STEP, Refined, further, refined
from analysis.gap.camera.base import Base
from analysis.gap.camera.blur import softened
from analysis.gap.camera.light import Light
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation

LEAST_BLUR_PX2 = 0.02
"""Blur from which edges are looked for: less moves no light from one pixel to the next."""

SHARPER = (1.0, 0.8)
"""Parts of a blur without edges that one with edges may have: 1.0 of that of the chart behind a
blur of 0.6 px, and 0.8 of that of patches with hard edges."""

NOTHING = 0.002
"""Part of the brightest rate that edges change at most where they make no difference."""


def with_edges(found: Refined, seen: Observation, scenery: Scenery) -> Refined:
    """The camera under light with edges within pixels, if that is likelier by as much as a step of
    a calibration is worth; else the same.

    Args:
        found: a camera against the frames.
        seen: the frames that fit.
        scenery: their light and shots.
    """
    light, base = scenery.light, found.base
    told = light.known and not light.drawn and base.blur_px2 >= LEAST_BLUR_PX2
    if not told or base.edges or not _matter(light, base):
        return found
    others = [
        dataclasses.replace(base, edges=True, blur_px2=part * base.blur_px2) for part in SHARPER
    ]
    against = (refined(other, seen, scenery, found.effects) for other in others)
    best = min(against, key=lambda one: one.deviance)
    if best.deviance > found.deviance - WORTH_A_STEP:
        return found
    return further(best, seen, scenery)


def _matter(light: Light, base: Base) -> bool:
    """Whether the picture of a lamp is another one with edges, in its middle colour."""
    picture = next(iter(light.falls.values()))[..., 1:2]
    pictures = (
        softened(picture, dataclasses.replace(base.blur, edges=edges)).reshape(picture.shape)
        for edges in (False, True)
    )
    without, with_them = pictures
    return bool(np.abs(without - with_them).max() > NOTHING * picture.max())
