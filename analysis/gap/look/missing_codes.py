"""Whether the codes that measured samples lack are missing where colours were filled in, too.

A converter lies before the demosaicer. A code that it leaves out is made again wherever a colour is
a mean of samples: of 99 and 101 it is 100. A table behind everything leaves it out of every pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.comb import histograms
from analysis.gap.look.lattices import Lattice, of_a_mosaic
from analysis.gap.look.statistics.codes import between_frequent

LEAST_CODES = 5
"""That measured samples lack: a few may be missing by chance."""

NEARLY_ALL = 0.9
"""Part of these that no other pixel has either. Where a converter left codes out, means of whole
codes make most of them again."""


def missing_everywhere(
    stacks: Sequence[NDArray[Any]], lattices: Sequence[Lattice], top_dn: int
) -> bool:
    """Whether codes were left out behind the demosaicer.

    Args:
        stacks: frames of lit shots as they came, (n, H, W, 3); others tell nothing.
        lattices: where the measured samples are.
        top_dn: the largest code.
    """
    coloured = [stack for stack in stacks if stack.ndim == 4]
    if not coloured or not of_a_mosaic(lattices):
        return False
    whole = [Lattice(name=c, channel=c, dy=0, dx=0, step=1) for c in "RGB"]
    measured, everywhere = (histograms(coloured, one, top_dn) for one in (lattices, whole))
    lacking = both = 0
    for channel, own in measured.items():
        filled = everywhere[channel] - own
        lacks = (own == 0) & between_frequent(np.array([own, filled])).all(axis=0)
        lacking += int(lacks.sum())
        both += int((lacks & (filled == 0)).sum())
    return both >= max(LEAST_CODES, NEARLY_ALL * lacking)
