"""`make bias`: the long runs behind the bias page; each goes on where it was cut off.

python -m analysis.bias coverage --camera i400 --seeds 2000 --method corrected
"""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import json
import statistics
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from analysis.bias import causes, failures, sweeps
from analysis.bias.coverage import bench, rows, scaled, trip
from analysis.bias.experiment import measure, run_cell
from analysis.bias.setting import Setting
from analysis.bias.technique import Technique, parameters
from analysis.debias import riddle, search
from analysis.reproduce.paper import printed
from foundation.jobs import run
from foundation.output import new_file

RUNS = Path("camtruth-out/bias")
RESULTS = Path("docs/results")


def main() -> None:
    """Run what the words ask for, and write the figures that the page shows."""
    parser = argparse.ArgumentParser(prog="python -m analysis.bias", description=__doc__)
    parser.add_argument("what", choices=["coverage", "cells", "debias", "failures"])
    parser.add_argument("--camera", default="i400")
    parser.add_argument("--raw", action="store_true")
    parser.add_argument("--seeds", type=int, default=2000)
    parser.add_argument("--method", action="append")
    parser.add_argument("--scheduler")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    {"coverage": coverage, "cells": cells, "debias": debias, "failures": failing}[options.what](
        options
    )


def coverage(options: argparse.Namespace) -> None:
    """Many bodies, and how often the truth lies in their intervals."""
    shared = bench(options.camera, options.method or ["corrected"], raw=options.raw)
    name = f"coverage-{options.camera}{'-raw' * options.raw}-{'-'.join(shared.methods)}"
    done = 0

    def progress(more: int) -> None:
        nonlocal done
        done += more
        if done % 20 == 0:
            print(f"{name}: {done} of {options.seeds}", flush=True)

    results = run(
        trip,
        {str(seed): seed for seed in range(options.seeds)},
        shared=shared,
        scheduler=options.scheduler,
        threads=options.threads,
        journal=RUNS / f"{name}.jsonl",
        question=shared.question,
        progress=progress,
    )
    found = rows(shared, list(results.values()))
    publish(name, {"seeds": options.seeds, "rows": [scaled(row) for row in found]})


def cells(options: argparse.Namespace) -> None:
    """Every cell of the bias page: causes switched off alone, and sweeps."""
    settings = causes.settings() | sweeps.all_settings()
    results = run(
        cell,
        settings,
        shared=(options.seeds, causes.techniques()),
        scheduler=options.scheduler,
        threads=options.threads,
        journal=RUNS / "cells.jsonl",
        question=f"cells of {options.seeds} bodies by {sorted(causes.techniques().items())!r}",
        progress=lambda done: print(f"cells: {done} more of {len(settings)}", flush=True),
    )
    publish("cells", {"seeds": options.seeds, "cells": results})


def cell(shared: tuple[int, Mapping[str, Technique]], setting: Setting) -> dict[str, Any]:
    """One cell."""
    seeds, techniques = shared
    return run_cell(setting, range(seeds), techniques)


def debias(options: argparse.Namespace) -> None:
    """The camera behind the printed figures, how it is read in simulation, and the riddle."""
    table = {key: figure.value for key, figure in printed().items()}
    found = {
        f"{order} {channel}": dataclasses.asdict(one)
        | {"floor": search.floor(channel, one.values, order)["fpn"]}
        for order in ("text", "printed")
        for channel in "RGB"
        for one in [search.search(channel, {k: table[k][channel] for k in search.KEYS}, order)]
    }
    setting = Setting(camera="i400-debiased")
    bodies = [measure(setting, seed) for seed in range(options.seeds)]
    read = [{c: parameters(b[c], c, demosaiced=True) for c in b} for b in bodies]
    simulated = {
        channel: {
            key: [
                statistics.mean(r[channel][key] for r in read),
                statistics.stdev(r[channel][key] for r in read),
            ]
            for key in search.KEYS
        }
        for channel in "RGB"
    }
    answers = {name: riddle.ratios(settings) for name, settings in riddle.ANSWERS.items()}
    publish(
        "i400-debiased",
        {"seeds": options.seeds, "found": found, "simulated": simulated, "answers": answers},
    )


def failing(options: argparse.Namespace) -> None:
    """Cases that go wrong, and where codes tell their noise."""
    seeds = range(options.seeds)
    publish(
        "failures",
        {
            "seeds": options.seeds,
            "ramps": failures.ramps(seeds),
            "none_at_all": failures.none_at_all(seeds),
            "rounding": failures.rounding((0.35, 0.5, 0.7, 1.0, 1.5, 2.5)),
            "tell_map": failures.tell_map(
                np.geomspace(0.1, 2.0, 14), np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0])
            ),
        },
    )


def publish(name: str, document: dict[str, Any]) -> None:
    """Write results with the day and the commit that they are of."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    RESULTS.mkdir(parents=True, exist_ok=True)
    with new_file(RESULTS / f"{name}.json") as scratch:
        text = json.dumps({"date": today, "commit": commit, **document}, indent=1, allow_nan=False)
        scratch.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
