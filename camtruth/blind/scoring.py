"""The seal opened: only after every answer is written and hashed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from camtruth.blind.answering import read_answers
from camtruth.blind.errors import BlindError
from camtruth.blind.format import SCORE_FORMAT, beside, open_seal, read_set
from camtruth.blind.marks import Mark, mark
from camtruth.blind.table import Score, table
from foundation.output import CHECKSUMS, sha256

MAIN = "answers"


def score(
    folder: Path,
    *,
    answers: Path | None = None,
    others: Mapping[str, Path] | None = None,
    seal: Path | None = None,
) -> dict[str, Any]:
    """The score of a set's answers, as plain data.

    Args:
        folder: the set.
        answers: their folder; the set's neighbour SET.answers by default.
        others: folders of other answers by name, scored beside them.
        seal: its folder; the neighbour SET.seal by default.

    Raises:
        BlindError: while an answer or the hashes are missing, or for another seal.
        DamageError: when an answer was changed after it was hashed.
    """
    document = read_set(folder)
    names = [case.name for case in document.case]
    places = {MAIN: answers or beside(folder, "answers"), **(others or {})}
    given = {who: read_answers(place, names) for who, place in places.items()}
    truth = open_seal(seal or beside(folder, "seal"), document.commitment)
    if set(truth.cases) != set(names):
        raise BlindError(
            "the seal is of other cases than the set",
            "expected the same names in both",
            "take the seal that was made with this set",
        )
    marks = {
        who: [mark(name, truth.cases[name], found[name]) for name in names]
        for who, found in given.items()
    }
    return {
        "format": SCORE_FORMAT,
        "set": document.name,
        "commitment": document.commitment,
        "hashes": {who: sha256(place / CHECKSUMS) for who, place in places.items()},
        "cases": _counted(marks[MAIN]),
        "missing_sources": list(document.missing_sources),
        "rows": {who: [dataclasses.asdict(row) for row in table(m)] for who, m in marks.items()},
        "marks": {who: [dataclasses.asdict(m) for m in found] for who, found in marks.items()},
    }


def _counted(marks: Sequence[Mark]) -> dict[str, int]:
    groups = [m.group for m in marks]
    return {group: groups.count(group) for group in dict.fromkeys(sorted(groups))}


def rows_of(document: Mapping[str, Any], who: str = MAIN) -> list[Score]:
    """The table of a score document."""
    return [Score(**row) for row in document["rows"][who]]


def tables_of(document: Mapping[str, Any]) -> dict[str, list[Score]]:
    """All tables of a score document, by who answered."""
    return {who: rows_of(document, who) for who in document["rows"]}


def marks_of(document: Mapping[str, Any], who: str = MAIN) -> list[Mark]:
    """The marks of a score document."""
    return [Mark(**one) for one in document["marks"][who]]


def percent(row: Score) -> str:
    """A figure with its interval, as a table shows it."""
    if row.value is None:
        return "–"
    share = f"{row.hits}/{row.cases}, " if row.hits is not None else f"of {row.cases}, "
    if row.low is None or row.high is None:
        return f"{share}{row.value:.0%}"
    return f"{share}{row.value:.0%} ({row.low:.0%} to {row.high:.0%})"


def markdown(tables: Mapping[str, Sequence[Score]]) -> str:
    """Tables as a page shows them, one column for each.

    Args:
        tables: by the head of their column; the first one says which rows there are.
    """
    heads = ["figure", "cases", "limits", "to reach", *tables]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    leading, *_ = tables.values()
    of_place = [{_place(row): row for row in rows} for rows in tables.values()]
    for row in leading:
        found = [rows.get(_place(row)) for rows in of_place]
        cells = ["–" if one is None else percent(one) for one in found]
        if any(cell != "–" for cell in cells):
            told = [row.figure, row.group, row.band, row.goal, *cells]
            lines.append("| " + " | ".join(told) + " |")
    return "\n".join(lines) + "\n"


def _place(row: Score) -> tuple[str, str, str]:
    return row.figure, row.group, row.band
