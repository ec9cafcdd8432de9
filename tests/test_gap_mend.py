"""How a demosaicer counts and how strong processing is, found in turns."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import pytest

from analysis.gap.calibrate.refine import Refined
from analysis.gap.camera.base import Base
from analysis.gap.suspects import mend
from analysis.gap.suspects.mend import Search, mended
from sensor.effect import Effect
from sensor.effects.spatial_denoise import SpatialDenoise
from tests.candidates import BASE

IN_FRACTIONS, IN_WHOLE_NUMBERS = 0, 1


def camera(rule: int, strength: float) -> Any:
    """A filter of 0.43 behind whole numbers: among fractions 0.26 fits best, and not well."""
    whole = rule == IN_WHOLE_NUMBERS
    best, least = (0.43, 0.9) if whole else (0.26, 1.5)
    misfit = least + 4 * abs(strength - best)
    return SimpleNamespace(
        base=dataclasses.replace(BASE, arithmetic=rule),
        effects=(SpatialDenoise(strength=strength),),
        misfit=misfit,
        deviance=1000.0 * misfit,
    )


def calibrated(base: Base, effect: Effect) -> Any:
    """Small steps lead on among whole numbers from 0.25 on, and otherwise stay where they are."""
    assert isinstance(effect, SpatialDenoise)
    leads = base.arithmetic == IN_WHOLE_NUMBERS and effect.strength > 0.25
    return "with it", camera(base.arithmetic, 0.43 if leads else effect.strength)


def valley(found: Any, seen: Any, scenery: Any) -> Any:
    """Another strength is likelier among fractions."""
    at = found.effects[-1].strength
    return None if at > 0.25 else camera(found.base.arithmetic, 0.26)


@pytest.mark.parametrize(("enough", "rule", "strength"), [(1.2, 1, 0.43), (2.0, 0, 0.2)])
def test_each_helps_the_other(
    enough: float, rule: int, strength: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From 0.2 whole numbers do not show; from the likelier strength they do. What leaves nothing
    is not mended."""
    monkeypatch.setattr(mend, "another_valley", valley)
    monkeypatch.setattr(mend, "counted", lambda found, seen, scenery, enough: found)
    scenery: Any = SimpleNamespace(rules=(IN_FRACTIONS, IN_WHOLE_NUMBERS))
    begun: Any = ("as it was", camera(IN_FRACTIONS, 0.2))

    def off(now: Refined) -> bool:
        return now.misfit > enough

    seen: Any = None
    search = Search(seen=seen, scenery=scenery, calibrated=calibrated, off=off)
    _, found = mended(begun, search)
    effect = found.effects[-1]
    assert isinstance(effect, SpatialDenoise)
    assert (found.base.arithmetic, effect.strength) == (rule, strength)
