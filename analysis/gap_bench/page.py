"""The table, the confusions and the detection limits in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from analysis.gap.report import EQUIVALENT
from analysis.gap_bench.answers import BANDS, Row, borne_out, confusion
from analysis.gap_bench.count import Line
from analysis.gap_bench.severity import THRESHOLD
from analysis.gap_bench.share import Share
from analysis.identifiability.limits import STANDARD_ERRORS, Limit

FEWEST = 20
"""Cases below which a line says neither that its target is reached nor that it is not."""

HEADS = ("", "feasibility study", "to reach", "measured", "95 % interval", "cases", "")


def cells(line: Line) -> tuple[str, ...]:
    """One line of the table as words."""
    mark = {True: "reached", False: "**not reached**", None: ""}[line.met]
    found = line.found
    if found is None:
        return line.what, line.study, line.target, "–", "", "0", mark
    cases = found.cases if isinstance(found, Share) else found[1]
    if line.met is not None and cases < FEWEST:
        mark = "too few cases"
    if isinstance(found, Share):
        value = found.value
        if value is None:
            return line.what, line.study, line.target, "–", "", "0", mark
        low, high = found.interval
        interval = f"{100 * low:.0f} to {100 * high:.0f} %"
        return (
            line.what,
            line.study,
            line.target,
            f"{100 * value:.0f} %",
            interval,
            str(found.cases),
            mark,
        )
    value, count = found
    return line.what, line.study, line.target, f"{100 * value:.1f} %", "", str(count), mark


def table(lines: Sequence[Line]) -> str:
    """All lines as a table in Markdown."""
    return markdown(HEADS, [cells(line) for line in lines])


def probabilities(rows: Sequence[Row]) -> str:
    """What a probability that is given with a name is worth."""
    made = []
    for (low, high), said, found in borne_out(rows):
        least, most = found.interval
        made.append(
            (
                f"{low:g} to {high:g}",
                f"{100 * said:.0f} %",
                f"{100 * (found.value or 0.0):.0f} %",
                f"{100 * least:.0f} to {100 * most:.0f} %",
                str(found.cases),
            )
        )
    return markdown(("probability", "said, on average", "right", "95 % interval", "names"), made)


def confusions(rows: Sequence[Row]) -> str:
    """The confusion matrix, one line per effect: an entry is severity band, answer and count."""
    found = confusion(rows)
    names = dict.fromkeys(name for name, _ in found)
    made: list[tuple[str, ...]] = []
    for name in sorted(names):
        if name == "nothing":
            made.append((name, "", "", _answers(found[name, ""], name)))
            continue
        made.append((name, *(_answers(found.get((name, b), {}), name) for b, _, _ in BANDS)))
    return markdown(("in the frames", *(f"{name} limits" for name, _, _ in BANDS)), made)


def _answers(counts: Mapping[str, int], name: str) -> str:
    if not counts:
        return "–"
    total = sum(counts.values())
    ordered = sorted(counts.items(), key=lambda item: (item[0] != name, -item[1], item[0]))
    return ", ".join(
        f"**{n} of {total}**" if word == name else f"{word} {n}" for word, n in ordered
    )


def limits_table(limits: Mapping[str, Limit]) -> str:
    """Detection limit of each effect in its own units, and what calibration takes up."""
    made = []
    for name, limit in sorted(limits.items()):
        figures = ", ".join(
            f"{p.replace('_', ' ')} {entry['value']:.3g}"
            + ("" if entry["unit"] == "1" else f" {entry['unit']}")
            for p, entry in limit.parameters.items()
        )
        note = ""
        if limit.steps:
            note = f"comes in steps; this one stands {limit.z:.0f} standard errors from zero"
        elif limit.z > THRESHOLD * STANDARD_ERRORS:
            note = f"begins at a threshold: {limit.z:.0f} standard errors as soon as it is seen"
        elif not limit.reached:
            note = f"not seen: {limit.z:.1f} standard errors at its strongest"
        elif limit.absorbed > EQUIVALENT:
            note = "calibration-equivalent"
        made.append((name, figures, f"{100 * limit.absorbed:.0f} %", note))
    return markdown(("effect", "at its detection limit", "taken up by calibration", ""), made)


def markdown(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)]) + "\n"
