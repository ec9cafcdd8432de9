"""One run at a time."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

from foundation.errors import OutputError


def claim(stream: IO[Any], what: Path) -> None:
    """Lock an open file until it is closed; the lock of a process that was killed is free.

    Args:
        stream: the file.
        what: is filled by this run.

    Raises:
        OutputError: when another run fills it.
    """
    try:
        import fcntl
    except ImportError:  # a system without such locks
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise OutputError(
            f"{what} is being filled by another run",
            "expected to be alone",
            "wait for it, or choose another --out",
        ) from None
