"""Work that lets go of the interpreter, such as files, codecs and checksums, on every core."""

from __future__ import annotations

import contextlib
import functools
import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

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


@contextlib.contextmanager
def products_on_one_core() -> Iterator[None]:
    """Keep each product of matrices to the core that asks for it, as long as this runs.

    Where every core has work of its own, a product that spreads over all of them takes them from
    that work, and its threads stay to ask for more: looking at frames took twice the time.
    """
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@functools.cache
def _libraries() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
