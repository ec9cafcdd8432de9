"""Slopes of spectra within the filters, as three colours tell them."""

from __future__ import annotations

from typing import Any

import drjit as dr

from sensor.colours import Colours
from sensor.image_plane import scene_mean
from sensor.neighbours import Neighbours, interleaved
from sensor.signal import Signal

EFFECTIVE_NM = Colours(R=610.0, G=530.0, B=460.0)
"""Maxima of the filters of a Sony interline CCD: those of scenes/data/surrogate.csv."""

WIDTH_NM = Colours(R=40.0, G=51.0, B=39.0)
"""Standard deviations of the same."""

BLACKEST = 0.01
"""Part of the scene's mean below which a colour has no slope: light that is hardly there."""

DARKEST_E_PER_S = 1e-20
"""Mean of a scene without any light of a colour, which has no slope either."""


Weights = tuple[tuple[float, float], ...]
"""Of red, green and blue: of the slope from green to red, and of that from blue to green."""

TO_THE_NEXT: Weights = ((1.0, 0.0), (0.5, 0.5), (0.0, 1.0))
"""Slopes to the next colours: of red and blue the one to green, of green the mean of both."""


def log_slopes_per_nm(signal: Signal, weights: Weights = TO_THE_NEXT) -> Any:
    """Slope of the logarithm of what each colour of a rate image sees, beyond that of the scene.

    A colour's light is more at one end of its filter than at the other, by how much the other
    colours say.

    Args:
        signal: a rate, (f, H, W, 3).
        weights: how slopes between the colours make up each colour's own.

    Returns:
        a tensor like it, in 1/nm.
    """
    mean = dr.maximum(scene_mean(signal), DARKEST_E_PER_S)
    near = Neighbours(signal.replace(signal.value / mean))
    red, green, blue = (
        dr.log(dr.maximum(near.flat_at(0, 0, colour), BLACKEST)) for colour in range(3)
    )
    above = (red - green) / (EFFECTIVE_NM.R - EFFECTIVE_NM.G)
    below = (green - blue) / (EFFECTIVE_NM.G - EFFECTIVE_NM.B)
    slopes = [of_above * above + of_below * below for of_above, of_below in weights]
    return near.tensor(interleaved(slopes), signal.shape)
