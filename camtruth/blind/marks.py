"""What one answer is worth, by the words of the gap report's format.

An answer is right when the true effect is the name given, right in class when it is in
`indistinguishable_from`, confidently wrong when it is neither and its probability is 0.5 or more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from analysis.gap.report import EQUIVALENT, Verdict
from camtruth.blind.format import CaseTruth, TrueEffect
from sensor.catalogue import catalogue

CONFIDENT = 0.5

BANDS = (("below 1", 0.0, 1.0), ("1 to 2", 1.0, 2.0), ("2 to 4", 2.0, 4.0),
         ("over 4", 4.0, float("inf")))  # fmt: skip
"""Severity in detection limits."""

QUIET: tuple[Verdict, ...] = ("matched", "insufficient data")
INTERVAL_Z = 1.6449
"""Standard errors on each side of an estimate that hold 90 % of a normal distribution."""

PLACES = 3


@dataclass(frozen=True, kw_only=True)
class Mark:
    """What an answer is worth.

    Attributes:
        case: its name.
        group: of `GROUPS`, or "calibration" for what calibration takes up.
        band: severity.
        truth: names of the true effects.
        said: verdict, and the names given.
        detected: it says that something is wrong.
        right, right_class: of the strongest effect named.
        wrong: confidently wrong.
        unexplained: says so, and names none.
        found: how many of the true effects are named, classes included.
        place: one of the places that differ most is of the true stage; None where none is told.
        errors: relative errors of the severities.
        covered: whether the 90 % interval holds the truth, for each of them.
        shrink: what the answer claims, where it names the right effect.
    """

    case: str
    group: str
    band: str
    severity: float
    truth: tuple[str, ...]
    said: tuple[str, ...]
    detected: bool
    right: bool
    right_class: bool
    wrong: bool
    unexplained: bool
    found: int
    place: bool | None
    errors: tuple[float, ...]
    covered: tuple[bool, ...]
    shrink: float | None


def band_of(severity: float) -> str:
    """The band that a severity is in."""
    return next(name for name, low, high in BANDS if low <= severity < high)


def mark(name: str, truth: CaseTruth, answer: Mapping[str, Any]) -> Mark:
    """Hold an answer against the truth."""
    # an effect that may not be suspected, or is in no catalogue, has no right name
    right_names = [() if e.name in truth.without else e.answers for e in truth.effects]
    all_names = {n for names in right_names for n in names}
    named = list(answer["effects"])
    first = named[0] if named else None
    classes = [{e["name"], *e.get("indistinguishable_from", [])} for e in named]
    right = first is not None and first["name"] in all_names
    found = sum(any(set(names) & c for c in classes) for names in right_names)
    errors, covered = _severities(truth, named) if right else ((), ())
    return Mark(
        case=name,
        group=_group(truth),
        band=band_of(truth.severity),
        severity=truth.severity,
        truth=tuple(e.name for e in truth.effects),
        said=(str(answer["verdict"]), *(str(e["name"]) for e in named)),
        detected=answer["verdict"] not in QUIET,
        right=right,
        right_class=bool(classes) and bool(classes[0] & all_names),
        wrong=any(
            e["probability"] >= CONFIDENT and not (c & all_names)
            for e, c in zip(named, classes, strict=True)
        ),
        unexplained=answer["verdict"] == "unexplained" and not named,
        found=found,
        place=_place(truth, answer),
        errors=errors,
        covered=covered,
        shrink=_shrink(answer) if right else None,
    )


def _group(truth: CaseTruth) -> str:
    single = truth.effects[0] if len(truth.effects) == 1 else None
    equivalent = single is not None and single.absorbed > EQUIVALENT and single.answers
    return "calibration" if equivalent and truth.group != "left-out" else truth.group


def _place(truth: CaseTruth, answer: Mapping[str, Any]) -> bool | None:
    where = answer.get("where")
    if not truth.effects or not isinstance(where, list) or not where:
        return None
    stages = {effect.stage for effect in truth.effects}
    return any(isinstance(w, dict) and w.get("stage") in stages for w in where[:PLACES])


def _shrink(answer: Mapping[str, Any]) -> float | None:
    gap = answer.get("gap")
    shrink = gap.get("shrink") if isinstance(gap, dict) and not gap.get("at_floor") else None
    return float(shrink) if isinstance(shrink, (int, float)) else None


def _severities(
    truth: CaseTruth, named: list[dict[str, Any]]
) -> tuple[tuple[float, ...], tuple[bool, ...]]:
    errors, covered = [], []
    for effect in truth.effects:
        given = next((e for e in named if e["name"] == effect.name), None)
        for key, identity, true in _strengths(effect):
            told = (given or {}).get("parameters", {}).get(key)
            value = told.get("value") if isinstance(told, dict) else None
            if not isinstance(value, (int, float)):
                continue
            errors.append(abs(value - true) / abs(true - identity))
            se = told.get("se") if isinstance(told, dict) else None
            if isinstance(se, (int, float)):
                covered.append(abs(value - true) <= INTERVAL_Z * se)
    return tuple(errors), tuple(covered)


def _strengths(effect: TrueEffect) -> list[tuple[str, float, float]]:
    """Name, identity and true value of what an effect of the catalogue has as its strength."""
    kind = catalogue().get(effect.name)
    found = []
    for p in kind.parameters() if kind and effect.source == "own" else ():
        true = effect.parameters.get(p.name)
        if p.identity is None or p.whole or not isinstance(true, (int, float)):
            continue
        if true != p.identity:
            found.append((p.name, float(p.identity), float(true)))
    return found
