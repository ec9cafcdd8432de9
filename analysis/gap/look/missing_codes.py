"""Whether the codes that measured samples lack are missing where colours were filled in, too.

A converter lies before the demosaicer. A code that it leaves out is made again wherever a colour is
a mean of samples: of 99 and 101 it is 100. A table behind everything leaves it out of every pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice, inner, of_a_mosaic
from analysis.gap.look.statistics.codes import between_frequent

FRAMES = 16
"""Of each shot."""

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
    coloured = [stack[:FRAMES] for stack in stacks if stack.ndim == 4]
    if not coloured or not of_a_mosaic(lattices):
        return False
    lacking = both = 0
    for channel in "RGB":
        own = [one for one in lattices if one.channel == channel]
        measured = sum(_counts(one.of(stack), top_dn) for one in own for stack in coloured)
        everywhere = sum(_counts(inner(s)[..., "RGB".index(channel)], top_dn) for s in coloured)
        filled = everywhere - measured
        lacks = (measured == 0) & between_frequent(np.array([measured, filled])).all(axis=0)
        lacking += int(lacks.sum())
        both += int((lacks & (filled == 0)).sum())
    return both >= max(LEAST_CODES, NEARLY_ALL * lacking)


def _counts(codes: NDArray[Any], top_dn: int) -> NDArray[np.intp]:
    return np.bincount(codes.ravel(), minlength=top_dn + 1)
