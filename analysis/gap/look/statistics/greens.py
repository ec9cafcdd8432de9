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

APART, BY_COLOUR = "greens apart", "greens apart by colour"

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
    one, other = by_name["G1"], by_name["G2"]
    return apart(one - other, (one + other) / 2, by_name["R"] - by_name["B"])


def apart(difference: Floats, green: Floats, colour: Floats) -> Figures:
    """Offset of the greens' difference over the mean of green, and its slope against the colour.

    Both are linear in the difference.

    Args:
        difference: G1 - G2 of each block in DN, (blocks,).
        green, colour: G and R - B of each block in DN, (blocks,).
    """
    colour = colour - colour.mean()
    return {
        APART: safe_ratio(difference.mean(), green.mean()),
        BY_COLOUR: safe_ratio(difference @ colour, colour @ colour + np.float64(LEAST)),
    }
