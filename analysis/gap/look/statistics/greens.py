"""The two greens of a mosaic against each other.

One green has red beside it and blue above, the other the reverse. Charge that goes to all four
neighbours alike brings both as much of either colour; what trails along the rows brings one green
red and the other blue,

    G1 - G2 = offset + slope (R - B),

so that the slope tells along which axis colours mix, and the offset whether the rows differ.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.gap.look.lattices import Lattice
from analysis.gap.look.statistics.group import Figures, Floats, safe_ratio

LEAST = 1.0
"""Sum of squares of the colour over all blocks in DN^2 below which there is none to speak of."""


def greens(images: Floats, lattices: Sequence[Lattice]) -> Figures:
    """Offset over the mean of green, and slope; nothing where there are not two greens.

    Args:
        images: block means of lit frames in DN, (lattices, blocks).
        lattices: of which they are.
    """
    by_name = {lattice.name: image for lattice, image in zip(lattices, images, strict=True)}
    if not {"R", "G1", "G2", "B"} <= set(by_name):
        return {}
    apart = by_name["G1"] - by_name["G2"]
    colour = by_name["R"] - by_name["B"]
    colour = colour - colour.mean()
    return {
        "greens apart": safe_ratio(apart.mean(), (by_name["G1"] + by_name["G2"]).mean() / 2),
        "greens apart by colour": safe_ratio(apart @ colour, colour @ colour + np.float64(LEAST)),
    }
