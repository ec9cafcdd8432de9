"""Where a suspect's calibration goes on, where no small step leads."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.suspects.anew import another_valley
from sensor.effects.color_matrix import ColorMatrix


def rugged(effect: ColorMatrix) -> float:
    """A deviance that has waves all along and a valley of a tenth of the way at 1.04."""
    off = (effect.saturation - 1.04) / 0.04
    return float(-100.0 * np.exp(-0.5 * (off / 0.1) ** 2) + np.cos(40.0 * off))


@pytest.mark.parametrize("begun", [1.03, 1.055, 1.07])
def test_a_strength_that_no_small_step_leads_to(begun: float) -> None:
    """From 0.6 to 1.75 times the strength some factor comes to within a tenth of the valley."""

    def against(base: Any, effect: Any) -> Any:
        return SimpleNamespace(base=base, effects=(effect,), deviance=rugged(effect))

    here = against(None, ColorMatrix(saturation=begun))
    found = another_valley(here, against)
    assert found is not None
    assert found.effects[-1].saturation == pytest.approx(1.04, abs=0.1 * 0.04)
    assert found.deviance < here.deviance - 50.0
    assert another_valley(against(None, ColorMatrix(saturation=1.04)), against) is None
