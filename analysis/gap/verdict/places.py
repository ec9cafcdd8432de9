"""Where the gap lies: figures, and panels of the mean image, in the order of their surprise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.space import Space
from analysis.gap.look.families import IMAGE, STAGES, stage_of
from analysis.gap.measure.case import Candidate
from analysis.gap.measure.measured import Measured
from analysis.gap.measure.signature import signature
from analysis.gap.ready.setting import Setting
from analysis.gap.report import Place

Floats = NDArray[np.float64]

MOST_PLACES = 12
"""Places of a report: those of the largest differences."""

ACCOUNTED = 0.5
"""Part of a difference that a suspect leaves of it at most if it accounts for it."""


def places(before: Measured, nearest: Candidate | None, setting: Setting) -> tuple[Place, ...]:
    """Where the capture differs most from a model, one entry for each kind of difference.

    A figure tells one stage from another less well than all of them together: what a suspect
    accounts for begins where that effect does, and anything else where gaps of its kind most often
    begin.

    Args:
        before: the capture against the model.
        nearest: the suspect that accounts for most of the gap.
        setting: the capture.
    """
    left, space = before.left, before.rod.turned.space
    count = len(space.keys)
    raw = left[:count] * space.spread
    of_it = _accounted(before, nearest)
    made = []
    for index in np.argsort(-np.abs(left[:count])):
        key = space.keys[index]
        usual = stage_of(key.family, key.statistic, lit=key.shot in setting.seen.lit)
        made.append(
            Place(
                family=key.family,
                statistic=key.statistic,
                stage=nearest.effect.stage.value if nearest and of_it[index] else usual,
                channel=None if key.lattice == "all" else key.lattice[0],
                shot=key.shot,
                panel=None,
                z=float(left[index]),
                size=float(raw[index]),
                unit="DN" if key.statistic == "dark level" else "1",
            )
        )
    made += image_places(left, space, setting)
    made.sort(key=lambda place: -abs(place.z))
    kinds: dict[tuple[str, str], Place] = {}
    for place in made:
        kinds.setdefault((place.family, place.statistic), place)
    return tuple(kinds.values())[:MOST_PLACES]


def _accounted(before: Measured, nearest: Candidate | None) -> NDArray[np.bool_]:
    """Which figures a suspect accounts for, of those of a model's space."""
    turned = before.rod.turned
    count = len(turned.space.keys)
    known = before.case.known
    shown = signature(nearest.effect, known, base=nearest.base) if nearest else None
    if shown is None:
        return np.zeros(count, dtype=bool)
    rest = before.left - turned.left(turned.space.vector(shown.figures, shown.means))
    return np.asarray(np.abs(rest) < ACCOUNTED * np.abs(before.left))[:count]


def image_places(left: Floats, space: Space, setting: Setting) -> list[Place]:
    """The panels, or quarters of the image, whose mean is most off."""
    count, size = len(space.keys), int(np.prod(space.shape))
    images = left[count : count + size].reshape(space.shape)
    down, across = setting.seen.grid
    spread = 1.0 / np.maximum(np.abs(space.whitening[..., range(space.shape[0]),
                                                     range(space.shape[0])]), 1e-9)  # fmt: skip
    height, width = setting.scenery.body.height, setting.scenery.body.width
    areas: list[tuple[str | None, slice, slice]] = [
        (
            p.name,
            _span(p.y * down / height, (p.y + p.h) * down / height),
            _span(p.x * across / width, (p.x + p.w) * across / width),
        )
        for p in (setting.scenery.light.panels or setting.capture.panels)
    ]
    areas = areas or [(None, slice(0, down), slice(0, across))]
    made = []
    for s, shot in enumerate(setting.scenery.shots):
        for c, channel in enumerate(setting.seen.channels):
            image = images[s, c].reshape(down, across)
            errors = spread[c, :, s].reshape(down, across)
            for name, rows, columns in areas:
                part = image[rows, columns]
                if part.size == 0:
                    continue
                made.append(
                    Place(
                        family=IMAGE,
                        statistic="mean of a panel",
                        stage=STAGES[IMAGE],
                        channel=channel,
                        shot=shot.label,
                        panel=name,
                        z=float(part.sum() / np.sqrt(part.size)),
                        size=float((part * errors[rows, columns]).mean()),
                        unit="DN",
                    )
                )
    return made


def _span(first: float, last: float) -> slice:
    """Whole blocks from the one that holds the first point."""
    return slice(int(first), max(int(first) + 1, int(last)))
