"""Scratch files and folders beside their target, that a killed process leaves and the next removes.

Each is locked while its process lives. The lock goes with the process, however it ends, so what can
be locked belongs to nobody and is swept away.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

MARK = ".camtruth-"
"""In the name of every scratch, so that nothing else is ever taken for one."""

UNCLAIMED = ".camtruth-new-"
"""Prefix for the moment between making and locking, in which a scratch must not be swept."""


@contextlib.contextmanager
def scratch(target: Path, *, folder: bool) -> Iterator[Path]:
    """A new file or folder beside a target, gone when the block ends unless it was moved.

    Raises:
        OSError: when the place cannot be written.
    """
    prefix = f".{target.name if folder else target.stem}{MARK}"
    suffix = "" if folder else target.suffix
    target.parent.mkdir(parents=True, exist_ok=True)
    _sweep(target.parent, prefix, suffix)
    with contextlib.ExitStack() as stack:
        made = _made(target.parent, suffix, folder=folder)
        stack.callback(_remove, made)
        stack.enter_context(_claimed(made))
        named = made.with_name(f"{prefix}{made.name.removeprefix(UNCLAIMED)}")
        made.replace(named)
        stack.callback(_remove, named)
        yield named


def _made(parent: Path, suffix: str, *, folder: bool) -> Path:
    if folder:
        return Path(tempfile.mkdtemp(prefix=UNCLAIMED, dir=parent))
    handle, name = tempfile.mkstemp(prefix=UNCLAIMED, suffix=suffix, dir=parent)
    os.close(handle)
    return Path(name)


@contextlib.contextmanager
def _claimed(path: Path) -> Iterator[bool]:
    """Lock a file or folder while the block lasts; False where it is another's, or locks fail."""
    try:
        import fcntl
    except ImportError:  # a system without such locks: nothing is ever swept there
        yield False
        return
    handle = -1
    try:
        handle = os.open(path, os.O_RDONLY)
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        locked = True
    except OSError:
        locked = False
    try:
        yield locked
    finally:
        if handle >= 0:
            os.close(handle)


def _sweep(parent: Path, prefix: str, suffix: str) -> None:
    for path in parent.iterdir():
        if path.name.startswith(prefix) and path.name.endswith(suffix) and not path.is_symlink():
            with _claimed(path) as free:
                if free:
                    _remove(path)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
