"""Work that lets go of the interpreter, such as files, codecs and checksums, on every core."""

from __future__ import annotations

import contextlib
import functools
import itertools
import os
from collections import deque
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


AHEAD = 2
"""Pieces of work that are begun before the result of the first is asked for."""


def ahead(begun: Iterable[Callable[[], Made]]) -> Iterator[Made]:
    """The results of work that goes on by itself once it has begun, in order, with the next pieces
    begun before each is waited for.

    Args:
        begun: pieces of work, each of which gives its result when called.
    """
    with products_on_one_core():
        waiting: deque[Callable[[], Made]] = deque()
        for one in begun:
            waiting.append(one)
            if len(waiting) > AHEAD:
                yield waiting.popleft()()
        while waiting:
            yield waiting.popleft()()


@contextlib.contextmanager
def libraries_beside_other_work() -> Iterator[None]:
    """Let kernels run on half of the cores for a while, and products of matrices on one.

    Threads of libraries that have nothing to do watch out for more, and a small product waits for
    all of its threads. Where other threads have work of their own, the first takes a fifth of the
    time of two cores, and a product of 0.7 ms takes 13.
    """
    import drjit

    before = drjit.thread_count()
    drjit.set_thread_count(max(1, min(before, cores() // 2)))
    try:
        with products_on_one_core():
            yield
    finally:
        drjit.set_thread_count(before)


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
