"""A likelier strength of an effect that no small step leads to."""

from __future__ import annotations

from collections.abc import Iterable

from analysis.gap.calibrate.refine import Refined, refined
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from analysis.gap.measure.signature import scaled

STRENGTHS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.25, 1.4)
"""Factors of a strength that are tried where no small step leads on: of whole codes each patch of a
chart goes over to the next one at a strength of its own, and what is likely is likely in a valley a
tenth wide."""

NEARER = (0.05, 0.025, 0.0125)
"""Parts by which the likeliest of these is changed, one after the other, either way: in its valley
derivatives do not show the way either."""


def another_valley(found: Refined, seen: Observation, scenery: Scenery) -> Refined | None:
    """The camera with the last effect of a likelier strength; None where there is none.

    Args:
        found: a camera with the effect, where small steps ended.
        seen: the frames that fit.
        scenery: their light and shots.
    """

    def likelier(than: Refined, factors: Iterable[float]) -> Refined:
        *others, last = than.effects
        tried = (
            refined(than.base, seen, scenery, (*others, scaled(last, factor))) for factor in factors
        )
        return min([than, *tried], key=lambda one: one.deviance)

    likeliest = likelier(found, STRENGTHS)
    for part in NEARER:
        likeliest = likelier(likeliest, (1.0 - part, 1.0 + part))
    return None if likeliest is found else likeliest
