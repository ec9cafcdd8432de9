"""Where a camera in a lit room begins: what darks gather by colour, or by the picture, is light."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import MOST_DARK_E_PER_S
from analysis.gap.camera.light_blocks import blocks_of
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, halves
from sensor.colours import CHANNELS, Colours
from sensor.effects.ambient_light import picture

Floats = NDArray[np.float64]

COLOURED = 0.15
"""Difference between the colours, as a part of their mean, that gains by moments do not have."""

SEEN_DN = 0.3
"""What the longest dark must gather for its colour to be told."""

STANDS_OUT = 10.0
"""Standard errors at which the scene is seen in the darks."""


def lit_room(setting: Setting) -> DirectReading | None:
    """Light of a colour or a picture in the darks, and the base by moments without it.

    Dark current is the same under every filter and knows no scene. A base that takes light for dark
    current makes up for it in its gains and its fixed pattern, and is no place to begin.

    Args:
        setting: the capture.
    """
    dark, base = by_moments(setting)
    gathered = dark.mean_dn_per_s / base.gain_dn_per_e
    shown = _of_the_scene(setting)
    if shown is not None:
        rate = shown / base.gain_dn_per_e
        left = float(np.clip((gathered - rate).mean(), 0.0, MOST_DARK_E_PER_S))
        return DirectReading(
            hints={"rate_e_per_s": _by_colour(rate), "share_in_dark": 1.0, "by_the_scene": 1.0},
            exact=False,
            base=dataclasses.replace(base, dark_e_per_s=left, shown_e_per_s=left),
        )
    if len(setting.seen.channels) == 1:
        return None
    longest_s = max((s.exposure_s for s in setting.scenery.shots if s.dark), default=0.0)
    if (dark.mean_dn_per_s * longest_s).max() < SEEN_DN or gathered.min() < 0:
        return None
    if np.ptp(gathered) < COLOURED * gathered.mean():
        return None
    return DirectReading(
        hints={"rate_e_per_s": _by_colour(gathered), "share_in_dark": 1.0, "by_the_scene": 0.0},
        exact=False,
        base=dataclasses.replace(base, dark_e_per_s=0.0, shown_e_per_s=0.0),
    )


def _by_colour(rate: Floats) -> float | Colours:
    """Figures of three channels, or that of one."""
    figures = [float(figure) for figure in rate]
    return figures[0] if len(figures) == 1 else Colours(**dict(zip(CHANNELS, figures, strict=True)))


def _of_the_scene(setting: Setting) -> Floats | None:
    """Light in DN per second that makes the picture of the scene in the darks, (channels,); None
    where no picture is seen.

    Least squares of the blocks of the darks, less their mean, on those of the picture times the
    exposure; the error of the slope is that of the blocks' scatter about it.
    """
    scenery, (seen, _) = setting.scenery, halves(setting.seen)
    if not scenery.light.rates:
        return None
    shown = blocks_of(picture(list(scenery.light.rates.values())), scenery.view, seen.channels)
    shown = shown - shown.mean(axis=1, keepdims=True)
    dark = [k for k, shot in enumerate(scenery.shots) if shot.dark and shot.exposure_s > 0]
    if not dark:
        return None
    exposure_s = np.array([scenery.shots[k].exposure_s for k in dark])
    blocks = seen.means.mean(axis=0)[dark]
    blocks = blocks - blocks.mean(axis=2, keepdims=True)
    length = np.square(exposure_s).sum() * np.square(shown).sum(axis=1)
    if not length.all():
        return None
    slope = np.einsum("k,kcb,cb->c", exposure_s, blocks, shown) / length
    left = blocks - exposure_s[:, None, None] * (slope[:, None] * shown)
    error = np.sqrt(np.square(left).mean(axis=(0, 2)) / length)
    return np.asarray(slope) if (slope > STANDS_OUT * error).all() else None
