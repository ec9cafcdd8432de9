"""Work that lets go of the interpreter, such as files, codecs and checksums, on every core."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Made = TypeVar("Made")

_given: list[int] = []


def cores() -> int:
    """Cores that this process may use: those it was given last, or all that it is allowed."""
    if _given:
        return _given[-1]
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def keep_to(count: int) -> None:
    """Let this process use so many cores from now on: kernels, files and statistics alike."""
    import drjit

    _given.append(count)
    drjit.set_thread_count(count)


def in_order(make: Callable[[Item], Made], items: Iterable[Item]) -> Iterator[Made]:
    """`make` of every item on all cores, in the order of the items, a few at a time."""
    count = cores()
    waiting = iter(items)
    with ThreadPoolExecutor(count) as pool:
        while batch := list(itertools.islice(waiting, 8 * count)):
            yield from pool.map(make, batch)
