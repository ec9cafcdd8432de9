"""Libraries that print their own complaints: silenced, so that a person reads one line, ours.

Some log through Python, some write to the process's standard error from C. While somebody is
quiet, all of that goes nowhere.
"""

from __future__ import annotations

import contextlib
import logging
import os
import threading
import warnings
from collections.abc import Iterator

LOGGERS = ("tifffile", "libav", "PIL", "zarr")
STANDARD_ERROR = 2

_lock = threading.Lock()
_saved: list[int] = []
"""Depth of quiet blocks over all threads: the first saves standard error, the last restores it."""


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Nothing that a library says is heard while the block lasts; warnings are errors in it."""
    for name in LOGGERS:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    _enter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ResourceWarning)
            yield
    finally:
        _leave()


def _enter() -> None:
    with _lock:
        if not _saved:
            saved = os.dup(STANDARD_ERROR)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, STANDARD_ERROR)
            os.close(nowhere)
            _saved.append(saved)
        else:
            _saved.append(-1)


def _leave() -> None:
    with _lock:
        saved = _saved.pop(0) if len(_saved) == 1 else _saved.pop()
        if saved >= 0:
            os.dup2(saved, STANDARD_ERROR)
            os.close(saved)
