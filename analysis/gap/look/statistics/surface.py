"""The surface of the dark: glow, leaking light, a black level that is not the same everywhere.

A corner that glows by a tenth of a DN is lost in the noise of every block, and far above that of a
corner.
"""

from __future__ import annotations

import numpy as np

from analysis.gap.look.statistics.group import Array, Group

CORNER = 6
"""Part of the height and of the width that is a corner, or the band along an edge."""

HOT = 4.0
"""Standard deviations at which samples are clipped, so that a few hot ones are no slope."""


def surface(group: Group) -> dict[str, float]:
    """Low orders of the mean of darks, and what corners and edges have above the rest, in DN."""
    if group.lit:
        return {}
    image = _clipped(group.mean)
    h, w = image.shape
    rows, columns = image.mean(axis=1), image.mean(axis=0)
    y, x = np.linspace(-1, 1, h), np.linspace(-1, 1, w)
    found = {
        "surface x": 3 * float((columns * x).mean()),
        "surface y": 3 * float((rows * y).mean()),
        "surface xx": float((columns * (x**2 - (x**2).mean())).mean()),
        "surface yy": float((rows * (y**2 - (y**2).mean())).mean()),
        "surface xy": 9 * float(y @ image @ x) / (h * w),
    }
    down, across = max(1, h // CORNER), max(1, w // CORNER)
    mean = float(image.mean())
    for name, part in (("left", columns[:across]), ("right", columns[-across:]),
                       ("top", rows[:down]), ("bottom", rows[-down:])):  # fmt: skip
        found[f"surface, {name}"] = float(part.mean()) - mean
    for top, vertical in ((True, slice(None, down)), (False, slice(-down, None))):
        for left, level in ((True, slice(None, across)), (False, slice(-across, None))):
            name = f"{'top' if top else 'bottom'} {'left' if left else 'right'}"
            found[f"surface, {name}"] = float(image[vertical, level].mean()) - mean
    return found


def _clipped(image: Array) -> Array:
    middle = float(np.median(image[::2, ::2]))
    reach = HOT * max(float(image.std()), 1e-3)
    return np.clip(image, middle - reach, middle + reach)
