"""What an answer is worth, case by case; how often names are right, and what is taken for what."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any

from analysis.gap.report import EQUIVALENT
from analysis.gap_bench.share import Share
from analysis.identifiability.limits import Limit

Row = Mapping[str, Any]
"""What `examine` says of a case."""

BANDS: tuple[tuple[str, float, float], ...] = (
    ("1 to 2", 1.0, 2.0),
    ("2 to 4", 2.0, 4.0),
    ("over 4", 4.0, math.inf),
)
"""Severities in detection limits; the lower end belongs to a band."""

SURE = 0.5
"""Probability from which a wrong answer is a confident one."""


def detected(row: Row) -> bool:
    """Whether the gap was seen, whatever it was put down to."""
    return row["verdict"] in ("explained", "partly explained", "unexplained")


def first(row: Row) -> Row | None:
    """The answer: the strongest effect that was named."""
    return row["named"][0] if row["named"] else None


def right(row: Row) -> bool:
    """Whether the answer is the true effect."""
    answer = first(row)
    return answer is not None and answer["name"] in row["truth"]


def in_class(row: Row) -> bool:
    """Whether the true effect is the answer, or one that it cannot be told from."""
    answer = first(row)
    return answer is not None and covers(answer, row)


def covers(answer: Row, row: Row) -> bool:
    """Whether a named effect, or its class, holds a true one."""
    return bool({answer["name"], *answer["alike"]} & set(row["truth"]))


def confidently_wrong(row: Row) -> bool:
    """Whether the answer is neither right nor in class and has a probability of a half or more."""
    answer = first(row)
    return answer is not None and not covers(answer, row) and answer["probability"] >= SURE


def one_too_many(row: Row) -> bool:
    """Whether a further effect was named with confidence that is not in the frames."""
    return any(
        not covers(named, row) and named["probability"] >= SURE for named in row["named"][1:]
    )


def found_of(row: Row) -> int:
    """How many of the true effects were named, or are in a class that was."""
    names = {name for named in row["named"] for name in (named["name"], *named["alike"])}
    return len(names & set(row["truth"]))


def band(rows: Iterable[Row], low: float, high: float) -> list[Row]:
    """Rows of a severity."""
    return [row for row in rows if low <= row["severity"] < high]


def equivalent(row: Row, limits: Mapping[str, Limit]) -> bool:
    """Whether calibration takes up more than 90 % of the one effect of a case: by its own camera's
    limit, or where that was not asked for, by that of the camera in the middle."""
    if len(row["truth"]) != 1:
        return False
    return float(row.get("absorbed", limits[row["truth"][0]].absorbed)) > EQUIVALENT


def takes_up_one(row: Row, limits: Mapping[str, Limit]) -> bool:
    """Whether calibration takes up one of a pair, by the camera in the middle."""
    return any(limits[name].absorbed > EQUIVALENT for name in row["truth"])


PROBABILITIES = (0.0, 0.3, 0.5, 0.7, 0.9, 1.0)
"""Where one band of probabilities ends and the next begins; the lower end belongs to a band."""


def borne_out(rows: Iterable[Row]) -> list[tuple[tuple[float, float], float, Share]]:
    """Of every name that was given, how often it was right, by the probability it was given with.

    Returns:
        for each band in which there are names, the band, the mean of what was said, and the share
        of names that were true or in a class with what is.
    """
    given = [(name, row) for row in rows if "skipped" not in row for name in row["named"]]
    made = []
    for low, high in itertools.pairwise(PROBABILITIES):
        inside = [(name, row) for name, row in given if low <= name["probability"] < high]
        if inside:
            said = sum(name["probability"] for name, _ in inside) / len(inside)
            good = sum(covers(name, row) for name, row in inside)
            made.append(((low, high), said, Share(hits=good, cases=len(inside))))
    return made


UNNAMED = {"matched": "not seen", "unexplained": "unexplained", "insufficient data": "no answer"}


def confusion(rows: Iterable[Row]) -> dict[tuple[str, str], dict[str, int]]:
    """Answers by true effect and severity band: how often which name was given.

    Answers that name nothing are `not seen`, `unexplained` and `no answer`; what is named in the
    true effect's class is `in class`.
    """
    table: dict[tuple[str, str], dict[str, int]] = {}
    for row in rows:
        if "skipped" in row or row["kind"] not in ("effect", "null"):
            continue
        name = row["truth"][0] if row["truth"] else "nothing"
        bands = [n for n, low, high in BANDS if low <= row["severity"] < high] or ["below 1"]
        answer = first(row)
        if answer is None:
            word = str(UNNAMED.get(row["verdict"], row["verdict"]))
        elif not right(row) and in_class(row):
            word = "in class"
        else:
            word = answer["name"]
        cell = table.setdefault((name, "" if name == "nothing" else bands[0]), {})
        cell[word] = cell.get(word, 0) + 1
    return table
