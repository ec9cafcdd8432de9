"""Light as frames show it, where nobody stated it: a picture without the camera's own pattern.

The noise of a response that differs from photosite to photosite is a part v of the light. Where a
neighbourhood varies by no more, it is all pattern; where by more, as at edges, it is kept as it is:

    light = mean + max(1 - v^2 / var, 0) (picture - mean)

the adaptive filter of J. S. Lee, Digital image enhancement and noise filtering by use of local
statistics, IEEE Trans. PAMI 2 (1980) 165. A filter that rounds edges off makes another picture of
them, and photosites reach the largest code elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, stats

from sensor.demosaicers import colour_demosaicing
from sensor.frames import Frames

Rate = NDArray[np.float32]

PICTURE_FRAMES = 32
"""Frames from which a picture is read."""

CLEAR_OF_THE_TOP = 0.9
"""Part of the largest code from which a pixel may be clipped."""

REACH_PX = 2
"""How far colours between are filled in from."""

SIDE_PX = 5
"""Of a neighbourhood."""

QUIETEST = 0.05
"""Part of the neighbourhoods that show no edge, in any picture. They are the quietest of all; of
those that show none all but as many are taken for pattern."""

LEAST_LIGHT = 1e-3
"""Of a neighbourhood, as a part of the mean: there is no part of less."""

NO_LIGHT = 1e-9
"""Of a picture that shows none."""


def picture(frames: Frames) -> NDArray[np.float32]:
    """Mean of the first frames in DN, as their pixels are: (H, W, 3) or (H, W)."""
    first = np.asarray(frames.dn[:PICTURE_FRAMES])
    return np.asarray(first.mean(axis=0, dtype=np.float32))


def plane(frames: Frames, black_dn: float) -> Rate:
    """Mean of the first frames above black, in three colours, (H, W, 3)."""
    mean = picture(frames) - np.float32(black_dn)
    if mean.ndim == 3:
        return np.asarray(mean)
    if frames.cfa is None:
        return np.repeat(mean[..., None], 3, axis=2)
    # mirrored about the outermost samples, as the mosaic goes on
    wider = np.pad(mean, 2, mode="reflect")
    three = colour_demosaicing().demosaicing_CFA_Bayer_bilinear(wider, frames.cfa)
    return np.asarray(three[2:-2, 2:-2], dtype=np.float32)


def clear(picture: Rate, frames: Frames, black_dn: float) -> NDArray[np.bool_]:
    """Where a picture (H, W, 3) of these frames has been clipped nowhere."""
    return np.asarray(picture < CLEAR_OF_THE_TOP * (frames.top_dn - black_dn))


def light_shown(shots: Sequence[tuple[float, Frames]], black_dn: float) -> Rate:
    """What shots of one lamp show of its light, in DN for one unit of it, (H, W, 3).

    The line through black that is nearest to all that are not clipped; where all are, the faintest.
    The pattern of a dark frame is twenty times the picture of a faint shot, as a part of it: no
    mean of such parts would do.

    Args:
        shots: how much light each had, and its frames.
        black_dn: pixel value without light.
    """
    pictures = [(np.float32(unit), plane(frames, black_dn), frames) for unit, frames in shots]
    use = [unit * _whole(picture, frames, black_dn) for unit, picture, frames in pictures]
    sums = np.sum([u * picture for u, (_, picture, _) in zip(use, pictures, strict=True)], axis=0)
    squares = np.sum(np.square(use), axis=0)
    unit, faintest, _ = min(pictures, key=lambda one: one[0])
    return np.asarray(np.divide(sums, squares, out=faintest / unit, where=squares > 0))


def _whole(picture: Rate, frames: Frames, black_dn: float) -> NDArray[np.bool_]:
    """Where no sample was clipped that a colour may have been filled in from."""
    reached = ndimage.maximum_filter(picture, (2 * REACH_PX + 1, 2 * REACH_PX + 1, 1))
    return clear(reached, frames, black_dn)


def without_pattern(image: Rate) -> Rate:
    """A picture (H, W, 3) without what each photosite makes of it."""
    seen = image.astype(np.float64)
    near = (SIDE_PX, SIDE_PX, 1)
    mean = ndimage.uniform_filter(seen, near)
    variance = ndimage.uniform_filter(np.square(seen), near) - np.square(mean)
    squares = np.square(np.maximum(mean, LEAST_LIGHT * np.abs(seen).mean() + NO_LIGHT))
    by_chance = stats.chi2(SIDE_PX**2 - 1)
    wider = by_chance.isf(QUIETEST) / by_chance.ppf(QUIETEST)
    of_pattern = wider * np.quantile(variance / squares, QUIETEST, axis=(0, 1)) * squares
    edge = 1.0 - np.divide(
        of_pattern, variance, out=np.ones_like(mean), where=variance > of_pattern
    )
    return np.asarray(np.clip(mean + edge * (seen - mean), 0, None), dtype=np.float32)
