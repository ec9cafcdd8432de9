"""So many of so many, and how sure that is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from scipy import stats

Item = TypeVar("Item")


@dataclass(frozen=True, kw_only=True)
class Share:
    """So many of so many."""

    hits: int
    cases: int

    @property
    def value(self) -> float | None:
        """The share; None where there is no case."""
        return self.hits / self.cases if self.cases else None

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval."""
        if self.cases == 0:
            return 0.0, 1.0
        ends = stats.binomtest(self.hits, self.cases).proportion_ci(method="wilson")
        return float(ends.low), float(ends.high)


def share(rows: Iterable[Item], good: Callable[[Item], bool]) -> Share:
    """How many rows are good."""
    rows = list(rows)
    return Share(hits=sum(good(row) for row in rows), cases=len(rows))
