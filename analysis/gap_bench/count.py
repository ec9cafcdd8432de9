"""The figures of the table from diagnosed cases: shares with Wilson intervals, by severity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.gap.measure.signature import strengths
from analysis.gap.search.choice import SIGNIFICANCE
from analysis.gap_bench.answers import (
    BANDS,
    Row,
    band,
    confidently_wrong,
    detected,
    equivalent,
    found_of,
    in_class,
    one_too_many,
    right,
    takes_up_one,
)
from analysis.gap_bench.share import Share, share
from analysis.identifiability.limits import Limit
from sensor.catalogue import catalogue

NOMINAL_90 = 1.645
"""Standard errors to either side of a 90 % interval."""


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
    left = [row for row in pairs if not takes_up_one(row, limits)]
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


@dataclass(frozen=True, kw_only=True)
class Off:
    """How far a strength is off.

    Attributes:
        relative: part of the true strength.
        in_errors: the same in standard errors.
    """

    relative: float
    in_errors: float


def strengths_off(rows: Sequence[Row]) -> list[Off]:
    """How far strengths of effects that are named and no calibration's own are off.

    Args:
        rows: cases of single effects; others are left out.
    """
    found = []
    for row in rows:
        answer, truth = row["named"][0], row["parameters"]
        name = answer["name"]
        for p in strengths(catalogue()[name]):
            value, se = answer["parameters"].get(p.name, [None, None])
            true = truth[name].get(p.name)
            off = p.identity or 0.0
            if value is None or true is None or not se or true == off:
                continue
            found.append(
                Off(relative=abs((value - true) / (true - off)), in_errors=abs(value - true) / se)
            )
    return found


def _severity(rows: Sequence[Row]) -> list[Line]:
    found = strengths_off(rows)
    inside = share(found, lambda one: one.in_errors <= NOMINAL_90)
    share_inside = inside.value
    middle = (float(np.median([one.relative for one in found])), len(found)) if found else None
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
