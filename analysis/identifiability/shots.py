"""Shots that one might take: darks, lamps at several levels and exposures, even fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from sensor.protocol import DARK, Shot

Rate = NDArray[np.float32]

EXPOSURE_S = 0.03268
"""The paper's longest; lamps are adjusted to it."""

DARK_PARTS = (0.25, 1.0, 8.0)
"""Exposures in the dark, of that one: the longest is for what grows in the dark."""

LEVELS = (0.25, 0.5, 1.0)
SHORT = 0.5
"""A lit shot at this part of the exposure, at full level: time and light told apart."""

UNIFORM = "uniform"
"""Light without a picture: an integrating sphere, or a white sheet before the lens."""

INTERVAL_S = 0.0667


def candidates(lamps: Sequence[str]) -> tuple[Shot, ...]:
    """Every shot that is considered, one frame each."""
    made = [_shot(f"dark-{1e3 * EXPOSURE_S * part:g}ms", DARK, 1.0, part) for part in DARK_PARTS]
    for lamp in (*lamps, UNIFORM):
        made += [_shot(f"{lamp}-{100 * level:03.0f}", lamp, level, 1.0) for level in LEVELS]
        made.append(_shot(f"{lamp}-100-short", lamp, 1.0, SHORT))
    return tuple(made)


def _shot(label: str, light: str, level: float, part: float) -> Shot:
    exposure_s = round(EXPOSURE_S * part, 6)
    return Shot(
        label=label,
        light=(light,),
        level=(level,),
        exposure_s=exposure_s,
        frames=1,
        interval_s=max(INTERVAL_S, round(1.2 * exposure_s, 4)),
    )


def with_uniform(rates: Mapping[str, Rate]) -> dict[str, Rate]:
    """The light of a scene and an even field, as bright as the scene is at its brightest tenth."""
    first = next(iter(rates.values()))
    bright = np.quantile(first.reshape(-1, 3), 0.9, axis=0).astype(np.float32)
    return {**rates, UNIFORM: np.broadcast_to(bright, first.shape).copy()}


def of_the_paper(lamps: Sequence[str]) -> tuple[str, ...]:
    """The shots of the paper that a diagnosis fits, where the scene has two lamps."""
    if len(lamps) < 2:
        return ()
    darks = [f"dark-{1e3 * EXPOSURE_S * part:g}ms" for part in DARK_PARTS[:2]]
    return (*darks, f"{lamps[0]}-050", f"{lamps[0]}-100", f"{lamps[1]}-100")
