"""Detection limits of effects for tests of the bench, as they are at their defaults."""

from __future__ import annotations

from typing import Any

from analysis.gap_bench.cases import suspects
from analysis.identifiability.limits import Limit
from sensor.catalogue import catalogue


def limit(name: str, **changed: Any) -> Limit:
    effect = catalogue()[name]()
    parameters = {
        p.name: {"value": getattr(effect, p.name), "unit": p.unit}
        for p in effect.parameters()
        if isinstance(getattr(effect, p.name), (int, float))
    }
    plain = {"z": 5.0, "absorbed": 0.0, "parameters": parameters, "steps": False}
    return Limit(name=name, **(plain | changed))


LIMITS = {name: limit(name) for name in suspects()}
