"""Steps of a calibration: by whose errors two cameras are compared."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.calibrate.calibration import Calibration
from analysis.gap.calibrate.refine import Refined
from analysis.gap.calibrate.space import Space

BLOCKS = 200
SEEN_DN = 100.0


def camera(mean_dn: float, error_dn: float) -> Refined:
    """A camera that expects one mean in all blocks of one shot, with one error."""
    space = Space(
        keys=(), expected_figures=np.zeros(0), expected_means=np.full((1, 1, BLOCKS), mean_dn),
        spread=np.zeros(0), whitening=np.full((1, BLOCKS, 1, 1), 1 / error_dn),
        shape=(1, 1, BLOCKS),
    )  # fmt: skip
    nothing_taken_up = Calibration(
        space=space, q=np.zeros((BLOCKS, 1)), solve=np.zeros((1, 1)), priors=np.zeros(1)
    )
    base: Any = SimpleNamespace()
    gap = space.blocks(np.full((1, 1, BLOCKS), SEEN_DN - mean_dn))
    return Refined(
        base=base, effects=(), bodies={}, light=nothing_taken_up, gap=gap, expected=float(BLOCKS)
    )


def test_a_wide_camera_is_nearer_by_its_own_errors_alone() -> None:
    """Off by d with an error s in n blocks is n (d / s)^2, whoever's d it is: a camera that is off
    by 3 with an error of 6 leaves less by its own errors than one that is off by 2 with 1, and more
    by those of the other."""
    narrow, wide = camera(98.0, 1.0), camera(97.0, 6.0)
    assert wide.chi2 == pytest.approx(BLOCKS * (3 / 6) ** 2)
    assert narrow.chi2 == pytest.approx(BLOCKS * (2 / 1) ** 2)
    assert narrow.chi2_of(wide) == pytest.approx(BLOCKS * (3 / 1) ** 2)
    assert wide.chi2_of(narrow) == pytest.approx(BLOCKS * (2 / 6) ** 2)
    assert narrow.chi2_of(narrow) == pytest.approx(narrow.chi2)
