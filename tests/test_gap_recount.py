"""What is asked anew of a model with an effect of processing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from analysis.gap.suspects import recount
from sensor.effect import Effect
from sensor.effects.blooming import Blooming
from sensor.effects.color_matrix import ColorMatrix
from sensor.effects.row_noise import RowNoise

NOTHING = cast(Any, None)


def model(base: str, effect: Effect) -> Any:
    return SimpleNamespace(base=base, effects=(effect,))


@pytest.mark.parametrize("effect", [ColorMatrix(saturation=1.04), Blooming(), RowNoise()])
@pytest.mark.parametrize("counts", ["in fractions", "in whole numbers"])
def test_the_strength_of_what_jumps_alone_is_looked_for_by_the_way_of_counting(
    effect: Effect, counts: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A matrix behind whole numbers was fitted behind fractions, at 1.036 instead of 1.030; and no
    small step leads back to a full well from one that nothing fills."""
    now = model("in fractions", effect)
    likelier = ColorMatrix(saturation=1.03)

    def counted(found: Any, *_: Any, **__: Any) -> Any:
        return found if counts == found.base else model(counts, effect)

    def further(begun: Any, seen: Any, scenery: Any, **how: Any) -> Any:
        assert how["tuned"] == effect.name
        return model(begun.base, begun.effects[-1])

    monkeypatch.setattr(recount, "counted", counted)
    monkeypatch.setattr(recount, "further", further)
    monkeypatch.setattr(recount, "in_finer_codes", lambda found, *_: found)
    monkeypatch.setattr(recount, "another_valley", lambda one, *_: model(one.base, likelier))
    found = recount.recounted(now, NOTHING, NOTHING)
    jumps = not isinstance(effect, RowNoise)
    assert found.base == counts
    assert found.effects == ((likelier,) if jumps else (effect,))
    assert (found is now) == (counts == "in fractions" and not jumps)
    monkeypatch.setattr(recount, "another_valley", lambda *_: None)
    assert recount.recounted(now, NOTHING, NOTHING).effects == (effect,)
