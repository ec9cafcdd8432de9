"""Estimators by name: ours, each a file in analysis/estimators, or a function in a user's file.

A file NAME.py in analysis/estimators that defines a function NAME is a method; there is no list
to keep. A user's is given as ``FILE.py:function``; both take a capture and return noise
parameters.
"""

from __future__ import annotations

import functools
import importlib
import importlib.util
import inspect
import math
import pkgutil
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from analysis import estimators
from analysis.errors import MethodError
from analysis.parameters import CannotTell, Estimate, NoiseParameters
from foundation.errors import InputError, unknown
from sensor.frames import Capture

Method = Callable[[Capture], NoiseParameters]

EXPECTED = "expected a function from a Capture to NoiseParameters"


def method_names() -> list[str]:
    """The methods that come with the package."""
    modules = [info.name for info in pkgutil.iter_modules(estimators.__path__)]
    return sorted(name for name in modules if callable(getattr(_ours(name), name, None)))


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


def _ours(name: str) -> ModuleType:
    return importlib.import_module(f"{estimators.__name__}.{name}")


def _users(path: Path, name: str) -> Method:
    module = _load(path)
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
            found = function(capture)
        except InputError:
            raise
        except Exception as error:
            raise MethodError(
                f"'{name}' raised {type(error).__name__}: {error} ({_where(error, path)})",
                EXPECTED,
                f"mend {path}",
            ) from error
        return _checked(found, name, path)

    return guarded


def _load(path: Path) -> ModuleType:
    """A user's file as a module of its own, anew each time."""
    if not path.is_file():
        raise MethodError(
            f"no file '{path}'", "expected a Python file with an estimator", "correct the path"
        )
    module_name = f"camtruth_user_{abs(hash(path.resolve())):x}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # dataclasses look their own module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[module_name]
        raise MethodError(
            f"{path} cannot be loaded, {type(error).__name__}: {error} ({_where(error, path)})",
            "expected a Python file with an estimator",
            "mend the file, or install what it imports",
        ) from error
    return module


def _where(error: BaseException, path: Path) -> str:
    """The last line of the user's file that the error passed through."""
    if isinstance(error, SyntaxError):
        return f"line {error.lineno}"
    line = None
    trace = error.__traceback__
    while trace is not None:
        if Path(trace.tb_frame.f_code.co_filename).resolve() == path.resolve():
            line = trace.tb_lineno
        trace = trace.tb_next
    return f"line {line}" if line else "outside the file"


def _checked(found: Any, name: str, path: Path) -> NoiseParameters:
    """What a user's estimator returned, if it is what the commands can use."""
    if not isinstance(found, NoiseParameters):
        raise MethodError(
            f"'{name}' in {path} returned {type(found).__name__}",
            "expected NoiseParameters",
            "end it with 'return NoiseParameters(method=..., channels=...)'",
        )
    for channel, findings in found.channels.items():
        for key, finding in findings.items():
            if isinstance(finding, CannotTell):
                continue
            if not isinstance(finding, Estimate):
                raise MethodError(
                    f"'{name}' returned {type(finding).__name__} for {key} of {channel}",
                    "expected an Estimate or CannotTell",
                    "write Estimate(value=..., se=..., unit=...)",
                )
            if not (math.isfinite(finding.value) and math.isfinite(finding.se)):
                raise MethodError(
                    f"'{name}' returned {finding.value} +- {finding.se} for {key} of {channel}",
                    "expected finite figures",
                    "return CannotTell(reason=...) where the frames cannot tell",
                )
    return found
