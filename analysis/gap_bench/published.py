"""Results that stand in the documentation: made from a run, and gone on from on another machine."""

from __future__ import annotations

import dataclasses
import datetime
import json
import subprocess
from pathlib import Path
from typing import Any

from analysis.gap_bench.cases import all_cases
from analysis.gap_bench.run import Place, code, question, read_limits, write_limits
from analysis.identifiability.limits import Limit
from foundation.journal import Journal
from foundation.output import new_file

PUBLISHED = Path("docs/results/gap")


def published(size: str, seed: int) -> Path:
    """The file of the documentation for captures of a size and the cameras of a seed."""
    return PUBLISHED / f"{size}-seed{seed}.json"


def document(place: Place, rows: list[dict[str, Any]], name: str) -> dict[str, Any]:
    """Everything that the documentation shows, as data."""
    limits = read_limits(place.limits)
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "commit": commit,
        "diagnosis": name.rpartition("-")[2],
        "size": place.size,
        "seed": place.seed,
        "planned": len(all_cases()),
        "limits": {key: dataclasses.asdict(limit) for key, limit in limits.items()},
        "rows": rows,
    }


def keep(found: dict[str, Any]) -> Path:
    """Write what the documentation shows; returns where."""
    path = published(found["size"], found["seed"])
    path.parent.mkdir(parents=True, exist_ok=True)
    with new_file(path) as scratch:
        scratch.write_text(json.dumps(found, allow_nan=False) + "\n", encoding="utf-8")
    return path


def go_on(place: Place, path: Path) -> int:
    """Begin where published results end, if they are of this diagnosis and these cameras.

    What a folder has of its own stays as it is.

    Returns:
        How many cases need not be done again.
    """
    if place.results.is_file() or not path.is_file():
        return 0
    found = json.loads(path.read_text(encoding="utf-8"))
    if (found["diagnosis"], found["size"], found["seed"]) != (code(), place.size, place.seed):
        return 0
    if not place.limits.is_file():
        write_limits(place, {name: Limit(**entry) for name, entry in found["limits"].items()})
    with Journal.open(place.results, question(place)) as journal:
        for row in found["rows"]:
            journal.append(row["case"], {key: row[key] for key in row if key != "case"})
    return len(found["rows"])
