"""A small scene made of the panels alone, for round trips that need nothing between them.

Analysis looks at six panels of 50 x 50 of 640 x 480 pixels: 5 % of the frame. Panels cut out with
a margin and set side by side give the same noise statistics for a twentieth of the work, as long
as no effect reaches across the margin. The colour phase of every pixel is kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from foundation.panel import Panel
from sensor.camera import Camera

MARGIN_PX = 4
"""Enough for any demosaicer with a 5 x 5 neighbourhood; even, to keep the colour phase."""


def panels_only(
    camera: Camera, rates: Mapping[str, NDArray[np.float32]], panels: Sequence[Panel]
) -> tuple[Camera, dict[str, NDArray[np.float32]], tuple[Panel, ...]]:
    """The camera, rate images and panels of the small scene.

    Args:
        camera: the full camera.
        rates: its rate images by lamp, (H, W, 3).
        panels: the panels, at least `MARGIN_PX` + 1 from the border and of one size.

    Returns:
        camera of the small size, rate images of that size, panels in their new places.
    """
    corners = [(p.y - MARGIN_PX - p.y % 2, p.x - MARGIN_PX - p.x % 2) for p in panels]
    height = _even(max(p.y + p.h - y for p, (y, _) in zip(panels, corners, strict=True)))
    width = _even(max(p.x + p.w - x for p, (_, x) in zip(panels, corners, strict=True)))
    height, width = height + MARGIN_PX, width + MARGIN_PX
    small = {
        lamp: np.concatenate([rate[y : y + height, x : x + width] for y, x in corners], axis=1)
        for lamp, rate in rates.items()
    }
    moved = tuple(
        Panel(name=p.name, x=p.x - x + k * width, y=p.y - y, w=p.w, h=p.h)
        for k, (p, (y, x)) in enumerate(zip(panels, corners, strict=True))
    )
    return camera.resized(height, width * len(panels)), small, moved


def _even(length: int) -> int:
    return length + length % 2
