"""Steps of a calibration: which of two cameras is the better one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.calibrate.calibration import Calibration
from analysis.gap.calibrate.refine import Refined, better
from analysis.gap.calibrate.space import Space
from analysis.gap.look.observation import Key

BLOCKS, FIGURES = 200, 50
KEYS = tuple(
    Key(shot="dark", lattice="G", family="pattern", statistic=str(k)) for k in range(FIGURES)
)


def camera(blocks_off_dn: float, width_dn: float, figures_off: float) -> Refined:
    """A camera that is off by so much in every block and, in standard errors, in every figure."""
    space = Space(
        keys=KEYS, expected_figures=np.zeros(FIGURES),
        expected_means=np.zeros((1, 1, BLOCKS)), spread=np.ones(FIGURES),
        whitening=np.full((1, BLOCKS, 1, 1), 1 / width_dn), shape=(1, 1, BLOCKS),
    )  # fmt: skip
    count = FIGURES + BLOCKS
    nothing_taken_up = Calibration(
        space=space, q=np.zeros((count, 1)), solve=np.zeros((1, 1)), priors=np.zeros(1)
    )
    base: Any = SimpleNamespace()
    gap = space.vector(np.full(FIGURES, figures_off), np.full((1, 1, BLOCKS), blocks_off_dn))
    return Refined(
        base=base, effects=(), bodies={}, light=nothing_taken_up, gap=gap, expected=float(count)
    )


@pytest.mark.parametrize(
    ("what", "one", "than", "taken"),
    [
        ("twice the width, as far off: 2 ln 2 - 3/4 a block is lost",
         camera(1.0, 2.0, 1.0), camera(1.0, 1.0, 1.0), False),
        ("half the width, as far off: 2 ln 2 is won, 3 lost",
         camera(1.0, 0.5, 1.0), camera(1.0, 1.0, 1.0), False),
        ("nearer by its own errors and likelier",
         camera(0.5, 1.0, 1.0), camera(1.0, 1.0, 1.0), True),
        ("wider, so less likely, but it fits, and its figures are nearer",
         camera(1.0, 2.0, 0.9), camera(1.0, 1.0, 1.2), True),
        ("the same where it does not fit",
         camera(2.4, 2.0, 0.9), camera(1.2, 1.0, 1.2), False),
        ("wider, and figures that are farther: too much fixed pattern",
         camera(1.0, 2.0, 1.3), camera(1.0, 1.0, 1.2), False),
    ],
)  # fmt: skip
def test_the_better_of_two_cameras(what: str, one: Refined, than: Refined, taken: bool) -> None:
    """n blocks that are off by d with a width w have a deviance of n (d^2 / w^2 + 2 ln w)."""
    assert better(one, than) is taken, what
