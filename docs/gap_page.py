"""docs/gap.md, from its text, the figures of the diagnosis, and the results of `make bench-gap`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from analysis.gap.calibrate.space import EDGE_FLOOR_PX, LIGHT_FLOOR
from analysis.gap.look.shots import GROUP_FRAMES, KEY_SHOTS
from analysis.gap.verdict.closing import LARGE, LEAST_PART
from analysis.gap.verdict.follow import MOST_EFFECTS
from analysis.gap.verdict.verdict import (
    BEYOND_CALIBRATION,
    CLASS_SIZE,
    EQUIVALENT,
    LEAST_SCORE,
    LEAST_SHRINK,
    MARGIN,
    MARGIN_OF_SCORE,
    SIGNIFICANCE,
)
from analysis.gap_bench.count import lines
from analysis.gap_bench.page import confusions, limits_table, table
from analysis.identifiability.limits import Limit
from foundation.output import new_file

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "gap.json"

FIGURES = {
    "GROUP_FRAMES": f"{GROUP_FRAMES}",
    "KEY_SHOTS": f"{KEY_SHOTS}",
    "LIGHT_FLOOR": f"{100 * LIGHT_FLOOR:g} %",
    "LARGE": f"{LARGE:g}",
    "LEAST_PART": f"{LEAST_PART:g}",
    "EDGE_FLOOR_PX": f"{EDGE_FLOOR_PX:g}",
    "BEYOND_CALIBRATION": f"{BEYOND_CALIBRATION:g}",
    "EQUIVALENT": f"{100 * EQUIVALENT:g} %",
    "SIGNIFICANCE": f"{SIGNIFICANCE:g}",
    "LEAST_SCORE": f"{LEAST_SCORE:g}",
    "MARGIN": f"{MARGIN:g}",
    "MARGIN_OF_SCORE": f"{100 * MARGIN_OF_SCORE:g} %",
    "CLASS_SIZE": f"{CLASS_SIZE}",
    "MOST_EFFECTS": f"{MOST_EFFECTS}",
    "LEAST_SHRINK": f"{100 * LEAST_SHRINK:g} %",
}


def write_gap_page() -> None:
    """The page."""
    found = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.is_file() else None
    others = [
        json.loads(path.read_text(encoding="utf-8"))
        for path in sorted(RESULTS.parent.glob("gap-*.json"))
    ]
    with new_file(HERE / "gap.md") as scratch:
        scratch.write_text(gap_page(found, others), encoding="utf-8")


def gap_page(found: dict[str, Any] | None, others: Sequence[dict[str, Any]] = ()) -> str:
    """The page with these results, or with none, and those of captures of other sizes."""
    text = (HERE / "gap_text.md").read_text(encoding="utf-8")
    more = [f"\n### Captures of {size(other)}\n\n{measured(other)}" for other in others]
    parts = FIGURES | {"measured": measured(found) + "".join(more), "limits": limits(found)}
    for name, words in parts.items():
        text = text.replace(f"<!-- {name} -->", words)
    return text


def measured(found: dict[str, Any] | None) -> str:
    """The table and the confusions."""
    rows = [row for row in found["rows"] if "skipped" not in row] if found else []
    if found is None or not rows:
        return "Not measured yet: `make bench-gap` has no published cases."
    limits = known(found)
    left_out = len(found["rows"]) - len(rows)
    return (
        f"Counted {found['date']} at commit {found['commit']}; measured with the diagnosis whose"
        f" files hash to {found['diagnosis']}:"
        f" {len(rows)} cases, and {left_out} that cannot be (an effect that has no such strength),"
        f" of {found['planned']} planned with seed {found.get('seed', 0)} (`make bench-gap SEED=2`"
        " takes others). The order of the cases is shuffled and fixed, so that"
        f" these are a fair sample. Captures are {size(found)}; every base figure is drawn anew for"
        " each. Severity is the strength in detection limits of the very camera of a case. **A line"
        " that rests on few cases says little: see its interval.** Effects that come from other"
        " people's code are not part of this bench (`camtruth blind`).\n\n"
        + table(lines(rows, limits))
        + "\nWhat is taken for what: bold is the true effect; the number is how often.\n\n"
        + confusions(rows)
    )


def limits(found: dict[str, Any] | None) -> str:
    """The detection limits."""
    if found is None or not found["limits"]:
        return "Not measured yet: `make bench-gap` has no published detection limits."
    return (
        "The detection limit is the strength at which the fitted effect stands five standard errors"
        " from zero once the camera is calibrated: the best that any search could do with these"
        f" figures, by a camera in the middle of the bench's ranges. Measured {found['date']} for"
        f" the paper's shots in captures of {size(found)}; more pixels and frames lower the limits"
        " of what is random in time, not of what the light's floor hides.\n\n"
        + limits_table(known(found))
    )


def known(found: dict[str, Any]) -> dict[str, Limit]:
    """The limits as they were found."""
    return {name: Limit(**entry) for name, entry in found["limits"].items()}


def size(found: dict[str, Any]) -> str:
    """Size of the captures in words."""
    width, height, frames = found["size"].split("x")
    return f"{width} x {height} pixels and {frames} frames of each shot"
