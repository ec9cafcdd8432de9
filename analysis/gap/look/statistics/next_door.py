"""Correlation of the noise of photosites next door to each other, whatever their colours.

Samples of one lattice are two photosites apart. What goes from a photosite into the next one after
it was counted, as charge that is left behind or pushed aside, is in the next lattice: of a part p
of the charge that is left behind both have the correlation p (1 - p) / (1 - 2 p + 2 p^2) where all
are as bright. What goes there before it is counted, as light does, leaves no correlation at all.
Charge that is left behind is more the further it has to go, so that the correlation grows along
the rows.
"""

from __future__ import annotations

import numpy as np

from analysis.gap.look.statistics.group import Array, Figures, Floats, safe_ratio

ACROSS = ((0, 1), (1, 0), (2, 3), (3, 2))
DOWN = ((0, 2), (2, 0), (1, 3), (3, 1))
"""Pairs of the four sites of a mosaic, (0, 0), (0, 1), (1, 0) and (1, 1): each site and the one to
its right, or below it. Where that is the first of two, it is the one of the next square."""


def next_door(noise: Array, variance: Floats) -> Figures:
    """Correlation across and down, and by how much it grows that way. Each is one number.

    Args:
        noise: in time, of the four lattices of a mosaic, (4, n, h, w).
        variance: of these where there are whole blocks, unbiased, (4,).
    """
    n = noise.shape[1]
    scale = np.sqrt(variance) * np.sqrt((n - 1) / n)
    found: Figures = {}
    for name, pairs, axis in (("across", ACROSS, 2), ("down", DOWN, 1)):
        along = np.mean([_along(noise, pair, axis, scale) for pair in pairs], axis=0)
        half = len(along) // 2
        found[f"next, {name}"] = along.mean()
        found[f"next, {name}, growing"] = along[-half:].mean() - along[:half].mean()
    return found


def _along(noise: Array, pair: tuple[int, int], axis: int, scale: Floats) -> Floats:
    """Correlation of each two lines, by their place along an axis of (n, h, w)."""
    site, beside = pair
    one, other = noise[site], noise[beside]
    count = one.shape[axis]
    last = count - 1
    rest = (slice(None),) * axis
    one = one[(*rest, slice(0, last))]
    other = other[(*rest, slice(0, last) if beside > site else slice(1, count))]
    kept = "w" if axis == 2 else "h"
    mean = np.einsum(f"nhw,nhw->{kept}", one, other).astype(np.float64) * (last / one.size)
    return safe_ratio(mean, scale[site] * scale[beside])
