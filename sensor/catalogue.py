"""Every effect there is, found by being a file in sensor/effects/ or a user's own file."""

from __future__ import annotations

import functools
import importlib
import inspect
import pkgutil
from pathlib import Path
from types import ModuleType
from typing import Any

import sensor.effects
from foundation.errors import unknown
from foundation.users_code import users_module
from sensor.effect import Effect
from sensor.errors import CameraError


def effects_in(module: ModuleType) -> list[type[Effect]]:
    """The effects that a module defines."""
    return [
        kind
        for kind in vars(module).values()
        if inspect.isclass(kind)
        and issubclass(kind, Effect)
        and not inspect.isabstract(kind)
        and kind.__module__ == module.__name__
    ]


@functools.cache
def catalogue() -> dict[str, type[Effect]]:
    """All effects by name, in the order of the signal path."""
    modules = [
        importlib.import_module(f"sensor.effects.{found.name}")
        for found in pkgutil.iter_modules(sensor.effects.__path__)
    ]
    kinds = [kind for module in modules for kind in effects_in(module)]
    return {kind.name: kind for kind in sorted(kinds, key=lambda kind: (kind.place(), kind.name))}


def effect(name: str) -> type[Effect]:
    """The effect of a name.

    Raises:
        CameraError: when there is none.
    """
    if name not in catalogue():
        raise unknown("effect", name, catalogue(), CameraError)
    return catalogue()[name]


def effects_from_file(path: Path) -> list[type[Effect]]:
    """The effects that a user's Python file defines.

    Raises:
        CameraError: when the file is missing, fails to run, or defines none.
    """
    module = users_module(path, "expected a Python file that defines effects", CameraError)
    kinds = effects_in(module)
    if not kinds:
        raise CameraError(
            f"{path} defines no effect",
            "expected a subclass of sensor.effect.Effect",
            "see docs/extending.md",
        )
    return kinds


def to_json() -> dict[str, Any]:
    """The catalogue as the contract spells it."""
    return {"effects": [_entry(kind) for kind in catalogue().values()]}


def _entry(kind: type[Effect]) -> dict[str, Any]:
    return {
        "name": kind.name,
        "stage": kind.stage.value,
        "base": kind.base,
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "default": p.default,
                "min": p.minimum,
                "max": p.maximum,
                "doc": p.doc,
            }
            for p in kind.parameters()
        ],
        "reference": kind.reference,
    }
