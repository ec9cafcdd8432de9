"""docs/gap.md, from its text, the figures of the diagnosis, and the results of `make bench-gap`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from analysis.gap.calibrate.figure_errors import PRIOR_FREEDOM
from analysis.gap.calibrate.fit import TWINS
from analysis.gap.calibrate.space import EDGE_FLOOR_PX, LIGHT_FLOOR, MODEL_ERROR
from analysis.gap.look.shots import GROUP_FRAMES, KEY_SHOTS
from analysis.gap.report import EQUIVALENT
from analysis.gap.search.choice import (
    BEYOND_CALIBRATION,
    CLASS_SIZE,
    CLOSES_ALONE,
    DOUBTED,
    LEAST_SCORE,
    LEAST_SHRINK,
    MARGIN,
    MARGIN_OF_SCORE,
    MAY_BE_NOTHING,
    MOST_OF_A_CROWD,
    NARROWEST_PATCH_PX,
    SIGNIFICANCE,
    TELLS_LITTLE,
    TEMPER,
    WEAK,
)
from analysis.gap.search.closing import HARDLY_CHANCE, LARGE, LEAST_PART
from analysis.gap.search.follow import ASTRAY_MISFIT, MORE_TWINS, MOST_EFFECTS
from analysis.gap.search.later import (
    LEADS,
    LEAST_OF_A_LATER,
    LEAST_WHERE_LITTLE,
    LITTLE_IS_LEFT,
    PART_OF_THE_FIRST,
)
from analysis.gap.search.remainder import RIGHT_TO
from analysis.gap.suspects.first_look import LITTLE, NEARLY_FITS, WEAKEST
from analysis.gap.suspects.pursue import CHOOSE_AGAIN_MISFIT
from analysis.gap.verdict.caps import (
    A_REMAINDER,
    CONTESTED,
    LARGEST_MISMATCH,
    MOST_AGAINST,
    MOST_BUT_TEXTURE,
    MOST_CERTAIN,
    MOST_IN_PART,
    NEARLY_ALL,
    OF_ROWS,
    ONE_SIDED,
    WIDEST_PATCH,
)
from analysis.gap.verdict.strength import OF_A_SEARCH
from analysis.gap.verdict.trust import (
    DOUBT,
    IN_PAIR,
    LATER,
    LIKELIER,
    OF_ONE_THAT_STANDS_OUT,
    SMALL,
)
from analysis.gap_bench.count import lines
from analysis.gap_bench.page import confusions, limits_table, probabilities, table
from analysis.gap_bench.run import Place
from analysis.identifiability.limits import Limit
from foundation.output import new_file

HERE = Path(__file__).parent
RESULTS = HERE / "results" / "gap"
USUAL_SIZE = Place(out=Path()).size

A_TABLE = 50
"""Cases from which a run has a table of its own; shorter ones count with all others."""

FIGURES = {
    "ASTRAY_MISFIT": f"{ASTRAY_MISFIT:g}",
    "GROUP_FRAMES": f"{GROUP_FRAMES}",
    "KEY_SHOTS": f"{KEY_SHOTS}",
    "LIGHT_FLOOR": f"{100 * LIGHT_FLOOR:g} %",
    "MODEL_ERROR": f"{100 * MODEL_ERROR:g} %",
    "MOST_Z": f"{1 / MODEL_ERROR:g}",
    "TWINS": f"{TWINS}",
    "MORE_TWINS": f"{MORE_TWINS}",
    "ONE_SIDED": f"{ONE_SIDED:g}",
    "SMALL": f"{SMALL:g}",
    "HARDLY_CHANCE": f"{HARDLY_CHANCE:g}",
    "FREEDOM_OF_TWINS": f"{TWINS - 1 + PRIOR_FREEDOM:g}",
    "LARGE": f"{LARGE:g}",
    "LEAST_PART": f"{LEAST_PART:g}",
    "EDGE_FLOOR_PX": f"{EDGE_FLOOR_PX:g}",
    "BEYOND_CALIBRATION": f"{BEYOND_CALIBRATION:g}",
    "LEAST_WHERE_LITTLE": f"{LEAST_WHERE_LITTLE:g}",
    "RIGHT_TO": f"{100 * RIGHT_TO:g} %",
    "EQUIVALENT": f"{100 * EQUIVALENT:g} %",
    "SIGNIFICANCE": f"{SIGNIFICANCE:g}",
    "LEAST_SCORE": f"{LEAST_SCORE:g}",
    "MARGIN": f"{MARGIN:g}",
    "NEARLY_FITS": f"{NEARLY_FITS:g}",
    "WEAKEST": f"{WEAKEST:g}",
    "LITTLE": f"{LITTLE:g}",
    "CHOOSE_AGAIN_MISFIT": f"{CHOOSE_AGAIN_MISFIT:g}",
    "MAY_BE_NOTHING": f"{MAY_BE_NOTHING:g}",
    "TELLS_LITTLE": f"{TELLS_LITTLE:g}",
    "MARGIN_OF_SCORE": f"{100 * MARGIN_OF_SCORE:g} %",
    "CLASS_SIZE": f"{CLASS_SIZE}",
    "MOST_EFFECTS": f"{MOST_EFFECTS}",
    "LEADS": f"{100 * LEADS:g} %",
    "LEAST_SHRINK": f"{100 * LEAST_SHRINK:g} %",
    "LITTLE_IS_LEFT": f"{LITTLE_IS_LEFT:g}",
    "OF_ONE_THAT_STANDS_OUT": f"{OF_ONE_THAT_STANDS_OUT:g}",
    "OF_A_SEARCH": f"{OF_A_SEARCH:g}",
    "TEMPER": f"{TEMPER:g}",
    "DOUBTED": f"{DOUBTED:g}",
    "WEAK_TO": f"{WEAK[0]:g}",
    "WEAK_FROM": f"{WEAK[1]:g}",
    "MOST_CERTAIN": f"{MOST_CERTAIN:g}",
    "MOST_IN_PART": f"{MOST_IN_PART:g}",
    "MOST_AGAINST": f"{MOST_AGAINST:g}",
    "MOST_BUT_TEXTURE": f"{MOST_BUT_TEXTURE:g}",
    "NEARLY_ALL": f"{100 * NEARLY_ALL:g} %",
    "OF_ROWS": ", ".join(f"`{name}`" for name in sorted(OF_ROWS)),
    "CONTESTED": f"{100 * CONTESTED:g} %",
    "WIDEST_PATCH": f"{WIDEST_PATCH:g}",
    "NARROWEST_PATCH_PX": f"{NARROWEST_PATCH_PX:g}",
    "LARGEST_MISMATCH": f"{LARGEST_MISMATCH:g}",
    "A_REMAINDER": f"{100 * A_REMAINDER:g} %",
    "LEAST_OF_A_LATER": f"{LEAST_OF_A_LATER:g}",
    "PART_OF_THE_FIRST": f"{100 * PART_OF_THE_FIRST:g} %",
    "LATER": f"{LATER:g}",
    "DOUBT": f"{DOUBT:g}",
    "IN_PAIR": f"{IN_PAIR:g}",
    "MOST_OF_A_CROWD": f"{MOST_OF_A_CROWD:g}",
    "CLOSES_ALONE": f"{CLOSES_ALONE:g}",
    "LIKELIER": f"{LIKELIER:g}",
}


def write_gap_page() -> None:
    """The page."""
    runs = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(RESULTS.glob("*.json"))]
    with new_file(HERE / "gap.md") as scratch:
        scratch.write_text(gap_page(runs), encoding="utf-8")


def gap_page(runs: Sequence[dict[str, Any]]) -> str:
    """The page with these runs of the bench: the table of the newest of the usual size that has
    many cases of several kinds, that of all of it together, then those of captures of other sizes;
    and what the newest run of the usual size can tell.
    """
    text = (HERE / "gap_text.md").read_text(encoding="utf-8")
    runs = sorted(runs, key=lambda run: (run["date"], run["seed"]))
    usual = [run for run in runs if run["size"] == USUAL_SIZE]
    of_all = [run for run in usual if len({row["kind"] for row in run["rows"]}) > 1]
    long = [run for run in of_all if len(run["rows"]) >= A_TABLE]
    newest = next(reversed(long or of_all or usual), None)
    others = (run for run in runs if run["size"] != USUAL_SIZE)
    more = [f"\n### Captures of {size(other)}\n\n{measured(other)}" for other in others]
    parts = FIGURES | {
        "measured": measured(newest),
        "together": together(usual) + "".join(more),
        "limits": limits(next(reversed(usual), None)),
    }
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
        f" of {found['planned']} planned with seed {found['seed']} (`make bench-gap SEED=2`"
        " takes others). The order of the cases is shuffled and fixed, so that"
        f" these are a fair sample. Captures are {size(found)}; every base figure is drawn anew for"
        " each. Severity is the strength in detection limits of the very camera of a case. **A line"
        " that rests on few cases says little: see its interval.** Effects that come from other"
        " people's code are not part of this bench (`camtruth blind`).\n\n"
        + table(lines(rows, limits))
        + "\nWhat is taken for what: bold is the true effect; the number is how often.\n\n"
        + confusions(rows)
    )


def together(runs: Sequence[dict[str, Any]]) -> str:
    """The table of all runs of a size, and what their probabilities were worth."""
    if not runs:
        return "Not measured yet: `make bench-gap` has no published cases."
    rows = [row for run in runs for row in run["rows"] if "skipped" not in row]
    nameless = sum(row["kind"] == "withheld" for row in rows)
    told = ", ".join(f"{run['seed']} by {run['commit']}" for run in runs)
    return (
        f"{len(rows)} cases of the seeds {told}, all of {size(runs[-1])}.\n\n"
        + table(lines(rows, known(runs[-1])))
        + "\nWhat a probability is worth: of all names that were given in these cases, how many are"
        f" true, or in a class with what is. In {nameless} of the {len(rows)} cases the effect is"
        " withheld, so that no name is; where such causes are more frequent, a name is worth"
        " less.\n\n" + probabilities(rows)
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
