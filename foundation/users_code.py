"""Code that people bring, such as an estimator: it may say what it likes, but not in our name.

Programs read our answers on standard output. What people's code prints, and the warnings that it
causes, are held back while it runs and told on standard error when it is done; where it fails, the
one line of our error is all that is read.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import io
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any, TextIO

from foundation.errors import InputError


class _Held(io.TextIOWrapper):
    """What is said meanwhile. A progress bar looks for `rich_proxied_file` and goes on there."""

    def __init__(self, behind: TextIO) -> None:
        super().__init__(io.BytesIO(), encoding="utf-8", errors="replace", write_through=True)
        self.rich_proxied_file = getattr(behind, "rich_proxied_file", behind)

    def text(self) -> str:
        """All of it."""
        self.seek(0)
        return self.read()


_lock = threading.Lock()
_streams: list[tuple[TextIO, TextIO, _Held]] = []
"""One entry for each block that runs, over all threads: the first holds back, the last tells."""


@contextlib.contextmanager
def users_code(file: object) -> Iterator[None]:
    """Run code of a user's file; see above.

    Raises:
        InputError: where it calls sys.exit().
    """
    _enter()
    said = False
    try:
        yield
        said = True
    except SystemExit as leave:
        raise InputError(
            f"{file} calls sys.exit({leave.code if leave.code is not None else ''})",
            "expected code that returns",
            "raise an error there, or return",
        ) from None
    finally:
        _leave(tell=said)


class _Anew(SourceFileLoader):
    """Compiles a file each time, and leaves no `__pycache__` beside it."""

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """Nothing that a cache could be held against."""
        raise OSError


def users_module(path: Path, expected: str, kind: type[InputError]) -> ModuleType:
    """A user's file as a module of its own, run anew each time.

    Args:
        path: the file.
        expected: what it should be, for the error.
        kind: of the error.

    Raises:
        InputError: of that kind, when the file is missing or fails.
    """
    if not path.is_file():
        raise kind(f"no file '{path}'", expected, "correct the path")
    name = f"camtruth_user_{hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path, loader=_Anew(name, str(path)))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their own module up
    try:
        with users_code(path):
            spec.loader.exec_module(module)
    except InputError:
        del sys.modules[name]
        raise
    except Exception as problem:
        del sys.modules[name]
        told = problem.msg if isinstance(problem, SyntaxError) else problem
        what = f"{type(problem).__name__}: {told} ({place_of(problem, path)})"
        raise kind(
            f"{path} cannot be loaded, {what}",
            expected,
            "mend the file, or install what it imports",
        ) from problem
    return module


def place_of(problem: BaseException, path: Path) -> str:
    """The last line of a user's file that an error passed through, in words."""
    line = problem.lineno if isinstance(problem, SyntaxError) else line_in(path, problem)
    return f"line {line}" if line else "outside the file"


@contextlib.contextmanager
def effects_of_users(files: Sequence[Path]) -> Iterator[None]:
    """Run code of ours that runs code of these files, if there are any.

    Raises:
        InputError: where code of theirs fails, or calls sys.exit().
    """
    if not files:
        yield
        return
    with users_code(" and ".join(map(str, files))):
        try:
            yield
        except InputError:
            raise
        except Exception as problem:
            for file in files:
                if line := line_in(file, problem):
                    raise InputError(
                        f"{file} fails with {type(problem).__name__}: {problem} (line {line})",
                        "expected effects that run on these frames",
                        "correct it",
                    ) from problem
            raise


def line_in(file: Path, problem: BaseException) -> int | None:
    """The last line of a file that an error passed through."""
    line, trace = None, problem.__traceback__
    while trace is not None:
        if Path(trace.tb_frame.f_code.co_filename).resolve() == file.resolve():
            line = trace.tb_lineno
        trace = trace.tb_next
    return line


def _enter() -> None:
    with _lock:
        if _streams:
            _streams.append(_streams[0])
            return
        held = _Held(sys.stderr)
        _streams.append((sys.stdout, sys.stderr, held))
        sys.stdout = sys.stderr = held


def _leave(*, tell: bool) -> None:
    with _lock:
        out, err, held = _streams.pop()
        if not tell:
            held.seek(0)
            held.truncate()
        if not _streams:
            sys.stdout, sys.stderr = out, err
            err.write(held.text())
