"""The surface of the dark: glow, leaking light, a black level that is not the same everywhere.

A corner that glows by a tenth of a DN is lost in the noise of every block, and far above that of a
corner.
"""

from __future__ import annotations

import numpy as np

from analysis.gap.look.statistics.group import Array, Figures, Floats, Group

CORNER = 6
"""Part of the height and of the width that is a corner, or the band along an edge."""

HOT = 4.0
"""Standard deviations at which samples are clipped, so that a few hot ones are no slope."""


def surface(group: Group) -> Figures:
    """Low orders of the mean of darks, and what corners and edges have above the rest, in DN."""
    if group.lit:
        return {}
    image = _clipped(group.mean)
    _, h, w = image.shape
    rows, columns = image.mean(axis=2), image.mean(axis=1)
    y, x = np.linspace(-1, 1, h), np.linspace(-1, 1, w)
    found = {
        "surface x": 3 * (columns @ x) / w,
        "surface y": 3 * (rows @ y) / h,
        "surface xx": columns @ (x**2 - (x**2).mean()) / w,
        "surface yy": rows @ (y**2 - (y**2).mean()) / h,
        "surface xy": 9 * (y @ image @ x) / (h * w),
    }
    down, across = max(1, h // CORNER), max(1, w // CORNER)
    mean = rows.mean(axis=1)
    for name, part in (("left", columns[:, :across]), ("right", columns[:, -across:]),
                       ("top", rows[:, :down]), ("bottom", rows[:, -down:])):  # fmt: skip
        found[f"surface, {name}"] = part.mean(axis=1) - mean
    for vertical, band in (("top", image[:, :down]), ("bottom", image[:, -down:])):
        for level, corner in (("left", band[..., :across]), ("right", band[..., -across:])):
            found[f"surface, {vertical} {level}"] = corner.mean(axis=(1, 2)) - mean
    return found


def _clipped(images: Array) -> Floats:
    middle = np.median(images[:, ::2, ::2], axis=(1, 2), keepdims=True)
    reach = HOT * np.maximum(images.std(axis=(1, 2), keepdims=True), 1e-3)
    return np.clip(images, middle - reach, middle + reach).astype(np.float64)
