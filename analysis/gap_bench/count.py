"""The figures of the table from diagnosed cases: shares with Wilson intervals, by severity."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.gap.measure.signature import strengths
from analysis.gap.verdict.verdict import EQUIVALENT, SIGNIFICANCE
from analysis.identifiability.limits import Limit
from sensor.catalogue import catalogue

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

NOMINAL_90 = 1.645
"""Standard errors to either side of a 90 % interval."""

CONFIDENCE = 1.96


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
        n, p, z = self.cases, self.hits / self.cases, CONFIDENCE
        centre = (p + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
        return max(0.0, centre - half), min(1.0, centre + half)


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of the table.

    Attributes:
        what: in words.
        found: a share, or a median with the number of cases that it rests on.
        target: what is to be reached, in words.
        study: what the feasibility study reached, in words.
        met: whether it is reached; None where there are no cases or there is no target.
    """

    what: str
    found: Share | tuple[float, int] | None
    target: str = ""
    study: str = ""
    met: bool | None = None


def share(rows: Iterable[Row], good: Callable[[Row], bool]) -> Share:
    """How many rows are good."""
    rows = list(rows)
    return Share(hits=sum(good(row) for row in rows), cases=len(rows))


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


def band(rows: Iterable[Row], low: float, high: float) -> list[Row]:
    """Rows of a severity."""
    return [row for row in rows if low <= row["severity"] < high]


def equivalent(row: Row, limits: Mapping[str, Limit]) -> bool:
    """Whether calibration takes up more than 90 % of the one effect of a case: by its own camera's
    limit, or where that was not asked for, by that of the camera in the middle."""
    if len(row["truth"]) != 1:
        return False
    return float(row.get("absorbed", limits[row["truth"][0]].absorbed)) > EQUIVALENT


def _takes_up_one(row: Row, limits: Mapping[str, Limit]) -> bool:
    """Whether calibration takes up one of a pair, by the camera in the middle."""
    return any(limits[name].absorbed > EQUIVALENT for name in row["truth"])


def lines(rows: Sequence[Row], limits: Mapping[str, Limit]) -> list[Line]:
    """The table."""
    kept = [row for row in rows if "skipped" not in row]
    by_kind: dict[str, list[Row]] = {k: [] for k in ("null", "effect", "withheld", "pair")}
    for row in kept:
        by_kind[row["kind"]].append(row)
    nulls = by_kind["null"]
    calibrated = [row for row in by_kind["effect"] if equivalent(row, limits)]
    named = [row for row in by_kind["effect"] if not equivalent(row, limits)]
    made = [
        _most(
            "false alarms on nulls (nominal 5 %)",
            share(nulls, lambda row: row["verdict"] != "matched"),
            0.07,
            "upper 95 % limit <= 7 %",
            "10 %",
            upper=True,
        ),
        Line(
            what="the same with no calibration, base figures known to 2 %",
            found=share(
                [row for row in nulls if row.get("p_unfitted") is not None],
                lambda row: row["p_unfitted"] < SIGNIFICANCE,
            ),
            target="far above 5 %",
        ),
    ]
    for (name, low, high), target, study in zip(
        BANDS, (0.9, 0.99, 0.99), ("46 to 100 %", "46 to 100 %", ""), strict=True
    ):
        made.append(
            _least(f"detected, {name} limits", share(band(named, low, high), detected), target,
                   study)
        )  # fmt: skip
    for (name, low, high), (one, many), before in zip(
        BANDS,
        ((0.9, 0.97), (0.92, 0.97), (0.98, 0.995)),
        (("89 %", "97 %"), ("83 %", "86 %"), ("98 %", "100 %")),
        strict=True,
    ):
        seen = [row for row in band(named, low, high) if detected(row)]
        words = f", of those detected, {name} limits"
        made.append(_least(f"right effect{words}", share(seen, right), one, before[0]))
        made.append(_least(f"right class{words}", share(seen, in_class), many, before[1]))
    for (name, low, high), target, study in zip(
        BANDS[1:], (0.75, 0.95), ("44 %", "88 %"), strict=True
    ):
        seen = band(by_kind["withheld"], low, high)
        seen = [row for row in seen if not equivalent(row, limits)]
        made.append(
            _least(
                f"withheld effect called unexplained, {name} limits",
                share(seen, lambda row: row["verdict"] == "unexplained"),
                target,
                study,
            )
        )
    for kind, words in (("effect", "effect in the catalogue"), ("withheld", "effect withheld")):
        for name, low, high in BANDS:
            if kind == "withheld" and high <= 2:
                continue
            made.append(
                _most(
                    f"confidently wrong, {words}, {name} limits",
                    share(band(by_kind[kind], low, high), confidently_wrong),
                    0.05,
                    "<= 5 %",
                    "83 % closed-set" if kind == "withheld" else "",
                )
            )
    made.append(
        Line(
            what="a further effect named beside the right one that is not there",
            found=share([row for row in named if right(row)], one_too_many),
        )
    )
    pairs = by_kind["pair"]
    left = [row for row in pairs if not _takes_up_one(row, limits)]
    made += [
        _least("pairs: both", share(pairs, lambda row: found_of(row) == 2), 0.75, "48 %"),
        _least(
            "pairs: both, where calibration takes up neither",
            share(left, lambda row: found_of(row) == 2),
            0.75,
            "",
        ),
        _least("pairs: at least one", share(pairs, lambda row: found_of(row) >= 1), 0.98, "93 %"),
        *_severity([row for row in named if right(row)]),
        _shrink([row for row in named if right(row) and row["severity"] >= BANDS[-1][1]]),
        Line(
            what="effects that calibration takes up: matched, or themselves",
            found=share(calibrated, lambda row: row["verdict"] == "matched" or in_class(row)),
        ),
    ]
    return made


def found_of(row: Row) -> int:
    """How many of the true effects were named, or are in a class that was."""
    names = {name for named in row["named"] for name in (named["name"], *named["alike"])}
    return len(names & set(row["truth"]))


def _severity(rows: Sequence[Row]) -> list[Line]:
    errors: list[float] = []
    covered: list[bool] = []
    for row in rows:
        answer, truth = row["named"][0], row["parameters"]
        name = answer["name"]
        for p in strengths(catalogue()[name]):
            value, se = answer["parameters"].get(p.name, [None, None])
            true = truth[name].get(p.name)
            off = p.identity or 0.0
            if value is None or true is None or not se or true == off:
                continue
            errors.append(abs((value - true) / (true - off)))
            covered.append(abs(value - true) <= NOMINAL_90 * se)
    inside = Share(hits=sum(covered), cases=len(covered))
    share_inside = inside.value
    middle = (float(np.median(errors)), len(errors)) if errors else None
    return [
        Line(
            what="severity: median error",
            found=middle,
            target="<= 10 %",
            met=None if middle is None else middle[0] <= 0.1,
        ),
        Line(
            what="severity: 90 % interval covers",
            found=inside,
            target="87 to 93 %",
            met=None if share_inside is None else 0.87 <= share_inside <= 0.93,
        ),
    ]


def _shrink(rows: Sequence[Row]) -> Line:
    values = [row["shrink"] for row in rows if not row["at_floor"] and row["shrink"] is not None]
    middle = (float(np.median(values)), len(values)) if values else None
    return Line(
        what="shrink after the right effect, over 4 limits, median",
        found=middle,
        target=">= 95 %",
        study="82 %",
        met=None if middle is None else middle[0] >= 0.95,
    )


def _least(what: str, found: Share, target: float, study: str) -> Line:
    value = found.value
    return Line(
        what=what,
        found=found,
        target=f">= {100 * target:g} %",
        study=study,
        met=None if value is None else value >= target,
    )


def _most(
    what: str, found: Share, target: float, words: str, study: str = "", upper: bool = False
) -> Line:
    value = found.interval[1] if upper else found.value
    return Line(
        what=what,
        found=found,
        target=words,
        study=study,
        met=None if value is None or not found.cases else value <= target,
    )


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
