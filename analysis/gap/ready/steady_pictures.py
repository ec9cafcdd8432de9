"""What cannot be where pictures are steady, so that no search needs to begin with it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis.gap.ready.black_level_drift import wanders
from analysis.gap.ready.full_well import lit
from analysis.gap.ready.hints import Hints
from sensor.frames import Frames

SPARSE = 4
"""Rows and columns from one that tells to the next: of how bright a frame is."""


def of_a_lamp(stacks: Sequence[Frames]) -> Hints:
    """Lamps that change alike and begin with each shot, where no light changes in time: those that
    change each by itself have more ways to begin with.

    Args:
        stacks: key frames of the shots.
    """
    means = [
        np.asarray(stack.dn[:, ::SPARSE, ::SPARSE], dtype=np.float64).reshape(stack.count, -1)
        for stack in lit(stacks)
    ]
    if means and wanders([one.mean(axis=1)[None] for one in means]):
        return {}
    return {"filament": 1.0, "on_before": 0.0}


def of_defects(trembles: bool) -> Hints:
    """Defects by their median, where typical samples have about as much noise as all: corrections
    that ask for more than all neighbours leave edges which come and go.

    Args:
        trembles: whether a few samples have most of the noise; see `trembling`.
    """
    return {} if trembles else {"beyond_all": 0.0}
