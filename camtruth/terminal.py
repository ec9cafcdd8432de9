"""What people see while and after a command runs: progress on standard error, tables, JSON."""

from __future__ import annotations

import contextlib
import json
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

PATIENCE_S = 1.0
"""What takes longer than this is reported."""

NUMBER = re.compile(r"[-+±–]?[\d.]*(e[-+]?\d+)?%?( ± .*)?$")


@contextlib.contextmanager
def progress(what: str, total: int | None = None) -> Iterator[Callable[[int], None]]:
    """Show that something goes on: call what this gives with the number of parts just finished.

    A bar on a terminal, gone when the block ends; one line at the end for what took long.
    """
    started = time.monotonic()
    with _bar(what, total) as advance:
        yield advance
    seconds = time.monotonic() - started
    if seconds > PATIENCE_S:
        print(f"{what}: {seconds:.1f} s", file=sys.stderr)


@contextlib.contextmanager
def _bar(what: str, total: int | None) -> Iterator[Callable[[int], None]]:
    if not sys.stderr.isatty():
        yield lambda parts: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)
        yield lambda parts: bar.advance(task, parts)


@contextlib.contextmanager
def telling(what: str, steps: int) -> Iterator[Callable[[str], None]]:
    """Show what goes on: call what this gives with the name of the step that begins.

    Args:
        what: the whole.
        steps: roughly how many there are, from which the time left is told.
    """
    started = time.monotonic()
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
        with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(what, total=steps)

            def say(step: str) -> None:
                bar.update(task, description=f"{what}: {step}", advance=1)

            yield say
    else:
        yield lambda step: None
    print(f"{what}: {time.monotonic() - started:.1f} s", file=sys.stderr)


def print_json(document: Any) -> None:
    """A document on standard output, as strict JSON."""
    print(json.dumps(document, indent=1, allow_nan=False))


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """A plain table on standard output: words to the left, columns of figures to the right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    rows = list(rows)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for index, head in enumerate(heads):
        figures = all(NUMBER.match(row[index]) for row in rows)
        table.add_column(head, justify="right" if figures else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    width = None if sys.stdout.isatty() else 200
    Console(width=width, highlight=False, markup=False).print(table)


def figure(value: float | None, digits: int = 3) -> str:
    """A figure to so many significant digits; a dash where there is none."""
    return "–" if value is None else f"{value:.{digits}g}"


def rounded(value: float | None, se: float | None) -> str:
    """A figure to the second digit of its standard error."""
    if value is None or se is None or not se > 0:
        return figure(value)
    return f"{value:.{max(0, 1 - _exponent(se))}f}"


def with_error(value: float | None, se: float | None) -> str:
    """A figure with its standard error, as in 1.613 ± 0.012."""
    return f"{rounded(value, se)} ± {rounded(se, se)}" if value is not None else figure(value)


def _exponent(value: float) -> int:
    """The power of ten of a positive figure."""
    return int(f"{value:e}".partition("e")[2])
