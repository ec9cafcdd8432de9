"""Several lamps at once: light adds, and so do the variances of independent renderings."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from render.batches import relative_noise
from render.errors import RenderError
from render.rate import RateImage, rate_image
from scenes.spectra import CHANNELS


def together(images: Mapping[str, RateImage], levels: Mapping[str, float]) -> RateImage:
    """The rate image of one scene under several of its lamps, each at a level.

    Raises:
        RenderError: for no lamp, one that was not rendered, or images of different scenes.
    """
    if not levels or not set(levels) <= set(images):
        raise RenderError(
            f"lamps {', '.join(levels) or 'none'} together",
            f"expected some of {', '.join(images)}",
            "render them first",
        )
    first = images[next(iter(levels))]
    for name in levels:
        image = images[name]
        if image.rate_e_per_s.shape != first.rate_e_per_s.shape or (
            image.header.scene,
            image.header.panels,
        ) != (first.header.scene, first.header.panels):
            raise RenderError(
                f"rate images of '{first.header.scene}' and '{image.header.scene}' together",
                "expected one scene at one size",
                "render them from the same scene",
            )
    rate = sum(np.float64(level) * images[n].rate_e_per_s for n, level in levels.items())
    variance = sum(np.float64(level) ** 2 * images[n].variance for n, level in levels.items())
    panels = first.header.panels
    noise = relative_noise(np.asarray(rate), np.asarray(variance), panels)
    header = dataclasses.replace(
        first.header,
        lamp="+".join(levels),
        samples=min(images[name].header.samples for name in levels),
        noise=dict(zip(CHANNELS, noise, strict=True)),
    )
    return rate_image(rate, variance, header)
