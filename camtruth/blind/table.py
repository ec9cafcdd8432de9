"""The score: every figure that a set can tell of a diagnosis, by severity, with its interval."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from camtruth.blind.intervals import difference, of_median, wilson
from camtruth.blind.marks import BANDS, Mark

OWN = ("own", "decoy", "put-back")
OTHERS = ("others",)
SINGLE = {
    "own code": OWN,
    "other people's code": OTHERS,
    "in no catalogue": ("strange",),
    "left out": ("left-out",),
}
NAMED_BANDS = tuple(name for name, _, _ in BANDS[1:])


@dataclass(frozen=True, kw_only=True)
class Score:
    """One figure of the table.

    Attributes:
        figure: what it is.
        group: of which cases.
        band: severity in detection limits; "all" where it is not divided.
        value: share, difference of shares, or median; None where no case tells.
        low, high: 95 % interval; None where there are too few cases for one.
        hits: of a share.
        cases: how many it rests on.
        goal: what is to be reached.
    """

    figure: str
    group: str
    band: str
    value: float | None
    low: float | None
    high: float | None
    hits: int | None
    cases: int
    goal: str


def table(marks: Sequence[Mark]) -> list[Score]:
    """All figures, in the order they are shown."""
    rows = [
        _share("false alarms", "nothing wrong", marks, ("null",), lambda m: m.detected,
               goal="upper limit <= 7 %"),
        _share("false alarms", "calibration takes it up", marks, ("calibration",),
               lambda m: m.detected, goal="upper limit <= 7 %"),
    ]  # fmt: skip
    goals = {"1 to 2": ">= 90 %", "2 to 4": ">= 99 %"}
    for group, groups in SINGLE.items():
        rows += _bands("detected", group, marks, groups, lambda m: m.detected, goals)
    effect = {"1 to 2": ">= 90 %", "2 to 4": ">= 92 %", "over 4": ">= 98 %"}
    kind = {"1 to 2": ">= 97 %", "2 to 4": ">= 97 %", "over 4": ">= 99.5 %"}
    for group in ("own code", "other people's code"):
        seen = [m for m in marks if m.detected]
        rows += _bands(
            "right effect, of those detected", group, seen, SINGLE[group], lambda m: m.right, effect
        )
        rows += _bands(
            "right class, of those detected",
            group,
            seen,
            SINGLE[group],
            lambda m: m.right_class,
            kind,
        )
    called = {"2 to 4": ">= 75 %", "over 4": ">= 95 %"}
    for group in ("in no catalogue", "left out"):
        rows += _bands(
            "called unexplained", group, marks, SINGLE[group], lambda m: m.unexplained, called
        )
        told = [m for m in marks if m.unexplained and m.place is not None]
        rows.append(
            _share("right place, of those", group, told, SINGLE[group], lambda m: bool(m.place))
        )
    every = {**SINGLE, "pairs": ("pair",), "nothing wrong": ("null",)}
    for group, groups in every.items():
        rows += _bands(
            "confidently wrong",
            group,
            marks,
            groups,
            lambda m: m.wrong,
            {name: "<= 5 %" for name, _, _ in BANDS},
            bands=[name for name, _, _ in BANDS],
        )
    rows += [
        _share("both found", "pairs", marks, ("pair",), lambda m: m.found == 2, goal=">= 75 %"),
        _share("one found", "pairs", marks, ("pair",), lambda m: m.found >= 1, goal=">= 98 %"),
        *_severities(marks),
        _shrink("shrink after the right effect", "own code", marks, OWN),
        _shrink("shrink with the effect put back", "left out", marks, ("put-back",)),
        _apart(marks),
    ]
    return rows


Is = Callable[[Mark], bool]


def _share(
    figure: str,
    group: str,
    marks: Iterable[Mark],
    groups: Sequence[str],
    is_hit: Is,
    *,
    band: str = "all",
    goal: str = "",
) -> Score:
    chosen = [m for m in marks if m.group in groups and band in ("all", m.band)]
    hits = sum(is_hit(m) for m in chosen)
    low, high = wilson(hits, len(chosen))
    return Score(
        figure=figure,
        group=group,
        band=band,
        value=hits / len(chosen) if chosen else None,
        low=low if chosen else None,
        high=high if chosen else None,
        hits=hits,
        cases=len(chosen),
        goal=goal,
    )


def _bands(
    figure: str,
    group: str,
    marks: Sequence[Mark],
    groups: Sequence[str],
    is_hit: Is,
    goals: dict[str, str],
    *,
    bands: Sequence[str] = NAMED_BANDS,
) -> list[Score]:
    return [
        _share(figure, group, marks, groups, is_hit, band=band, goal=goals.get(band, ""))
        for band in bands
        if band != "below 1" or any(m.band == band and m.group in groups for m in marks)
    ]


def _severities(marks: Sequence[Mark]) -> list[Score]:
    own = [m for m in marks if m.group in OWN]
    errors = [e for m in own for e in m.errors]
    covered = [c for m in own for c in m.covered]
    low, high = wilson(sum(covered), len(covered))
    return [
        _median("severity, relative error (median)", "own code", errors, "all", "<= 10 %"),
        Score(
            figure="severity, 90 % interval covers",
            group="own code",
            band="all",
            value=sum(covered) / len(covered) if covered else None,
            low=low if covered else None,
            high=high if covered else None,
            hits=sum(covered),
            cases=len(covered),
            goal="87 to 93 %",
        ),
    ]


def _shrink(figure: str, group: str, marks: Sequence[Mark], groups: Sequence[str]) -> Score:
    told = [m for m in marks if m.group in groups and m.band == "over 4"]
    values = [m.shrink for m in told if m.shrink is not None]
    return _median(f"{figure} (median)", group, values, "over 4", ">= 95 %")


def _median(figure: str, group: str, values: Sequence[float], band: str, goal: str) -> Score:
    ends = of_median(values)
    return Score(
        figure=figure,
        group=group,
        band=band,
        value=float(np.median(values)) if values else None,
        low=ends[0] if ends else None,
        high=ends[1] if ends else None,
        hits=None,
        cases=len(values),
        goal=goal,
    )


def _apart(marks: Sequence[Mark]) -> Score:
    def right(groups: Sequence[str]) -> tuple[int, int]:
        chosen = [m for m in marks if m.group in groups and m.detected and m.band in NAMED_BANDS]
        return sum(m.right_class for m in chosen), len(chosen)

    one, two = right(OTHERS), right(OWN)
    told = one[1] > 0 and two[1] > 0
    low, high = difference(one, two)
    return Score(
        figure="right class, other people's code less own code",
        group="both",
        band="1 and over",
        value=one[0] / one[1] - two[0] / two[1] if told else None,
        low=low if told else None,
        high=high if told else None,
        hits=None,
        cases=one[1] + two[1],
        goal=">= -5 %",
    )
