"""Work that lets go of the interpreter, such as files, codecs and checksums, on every core."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Made = TypeVar("Made")


def in_order(make: Callable[[Item], Made], items: Iterable[Item]) -> Iterator[Made]:
    """`make` of every item on all cores, in the order of the items, a few at a time."""
    cores = os.cpu_count() or 1
    waiting = iter(items)
    with ThreadPoolExecutor(cores) as pool:
        while batch := list(itertools.islice(waiting, 8 * cores)):
            yield from pool.map(make, batch)
