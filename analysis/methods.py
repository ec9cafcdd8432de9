"""Estimators by name: ours, each a file in analysis/estimators, or a function in a user's file.

A file NAME.py in analysis/estimators that defines a function NAME is a method; there is no list
to keep, and what methods share is in its folders. What a method does not define of the paper's
parameters it may list with reasons as UNDEFINED. A user's is given as ``FILE.py:function``; both
take a capture and return noise parameters.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import inspect
import json
import math
import numbers
import pkgutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from analysis import estimators
from analysis.errors import MethodError
from analysis.parameters import UNITS, CannotTell, Estimate, Finding, NoiseParameters
from foundation.errors import InputError, unknown
from foundation.users_code import place_of, users_code, users_module
from sensor.frames import Capture

Method = Callable[[Capture], NoiseParameters]

EXPECTED = "expected a function from a Capture to NoiseParameters"


def method_names() -> list[str]:
    """The methods that come with the package."""
    files = [info.name for info in pkgutil.iter_modules(estimators.__path__) if not info.ispkg]
    return sorted(name for name in files if callable(getattr(_ours(name), name, None)))


def method(name: str) -> Method:
    """The estimator of that name, or the one that ``FILE.py:function`` names.

    Raises:
        MethodError: for a name that is neither, a file that cannot be loaded, a function that
            does not take one capture; and, when the estimator of a user's file is called, for
            one that fails or returns anything but noise parameters.
    """
    path, colon, function = name.rpartition(":")
    if colon and path.endswith(".py"):
        return _users(Path(path), function)
    names = method_names()
    if name not in names:
        error = unknown("method", name, names, MethodError)
        raise MethodError(
            error.found, f"{error.expected}, or FILE.py:function", error.remedy
        ) from None
    ours: Method = getattr(_ours(name), name)
    return ours


def undefined(name: str) -> Mapping[str, str]:
    """Parameters that one of our methods does not define, each with the reason."""
    found: Mapping[str, str] = (
        getattr(_ours(name), "UNDEFINED", {}) if name in method_names() else {}
    )
    return found


def _ours(name: str) -> ModuleType:
    return importlib.import_module(f"{estimators.__name__}.{name}")


def _users(path: Path, name: str) -> Method:
    module = users_module(path, "expected a Python file with an estimator", MethodError)
    function = getattr(module, name, None)
    if function is None:
        defined = sorted(
            key
            for key, value in vars(module).items()
            if inspect.isfunction(value) and value.__module__ == module.__name__
        )
        raise MethodError(
            f"no function '{name}' in {path}",
            f"expected one of {', '.join(defined)}" if defined else EXPECTED,
            f"write it, or name another: {path}:FUNCTION",
        )
    if not callable(function):
        raise MethodError(f"'{name}' in {path} is no function", EXPECTED, f"define '{name}' as one")
    try:
        inspect.signature(function).bind(None)
    except (TypeError, ValueError):
        raise MethodError(
            f"'{name}' in {path} cannot be called with one argument",
            EXPECTED,
            f"write it as 'def {name}(capture):'",
        ) from None

    @functools.wraps(function)
    def guarded(capture: Capture) -> NoiseParameters:
        try:
            with users_code(path):
                found = function(capture)
        except InputError:
            raise
        except Exception as error:
            raise MethodError(
                f"'{name}' raised {type(error).__name__}: {error} ({place_of(error, path)})",
                EXPECTED,
                f"mend {path}",
            ) from error
        return _checked(found, capture.channels, f"'{name}' in {path}")

    return guarded


def _checked(found: Any, channels: tuple[str, ...], where: str) -> NoiseParameters:
    """What a user's estimator returned, if it is what the commands can use."""
    if not isinstance(found, NoiseParameters):
        raise MethodError(
            f"{where} returned {type(found).__name__}",
            "expected NoiseParameters",
            "end it with 'return NoiseParameters(method=..., channels=...)'",
        )
    try:
        plain = {
            channel: {
                key: _finding(finding, key, f"{where} returned", f"for {key} of {channel}")
                for key, finding in findings.items()
            }
            for channel, findings in found.channels.items()
        }
        checked: NoiseParameters = dataclasses.replace(found, channels=plain)
        json.dumps(checked.to_json(), allow_nan=False)
    except (AttributeError, TypeError, ValueError) as problem:
        if isinstance(problem, InputError):
            raise
        raise MethodError(
            f"{where} returned noise parameters that are no JSON ({problem})",
            "expected findings by channel and parameter, and plain figures and text",
            "write NoiseParameters(method='...', channels={'R': {'read': ...}})",
        ) from None
    for channel in plain:
        if channel not in channels:
            raise MethodError(
                f"{where} returned a channel '{channel}'",
                f"expected {', '.join(channels)} as the capture has",
                "go through capture.channels",
            )
    return checked


def _finding(finding: Any, key: str, who: str, which: str) -> Finding:
    if isinstance(finding, CannotTell):
        return finding
    if not isinstance(finding, Estimate):
        raise MethodError(
            f"{who} {type(finding).__name__} {which}",
            "expected an Estimate or CannotTell",
            "write Estimate(value=..., se=..., unit=...)",
        )
    figures: tuple[Any, Any] = finding.value, finding.se
    if not all(isinstance(f, numbers.Real) and not isinstance(f, bool) for f in figures):
        raise MethodError(
            f"{who} {finding.value!r} +- {finding.se!r} {which}",
            "expected two numbers",
            "write Estimate(value=..., se=..., unit=...) with plain figures",
        )
    value, se = float(finding.value), float(finding.se)
    if not (math.isfinite(value) and math.isfinite(se)):
        raise MethodError(
            f"{who} {value} +- {se} {which}",
            "expected finite figures",
            "return CannotTell(reason=...) where the frames cannot tell",
        )
    if se < 0:
        raise MethodError(
            f"{who} a standard error of {se:g} {which}", "expected none below 0", "correct se"
        )
    unit = UNITS.get(key, finding.unit)
    if finding.unit != unit:
        raise MethodError(
            f"{who} {finding.unit!r} as the unit {which}", f"expected '{unit}'", "convert it"
        )
    return Estimate(value=value, se=se, unit=unit)
