"""The paper's protocol measured after loading: 9 shots of 100 frames, 6 panels, by every method.

Promised is one second; the ratio is one second over the processor time of the fastest of a few
runs, which is the time on a machine with nothing else to do. The study promises its 1080 cells in
20 minutes on two cores; the ratio is that over the processor time of a few cells.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

from analysis.bias.coverage import bench
from analysis.methods import method, method_names
from analysis.study.cell import Plan, run_case
from analysis.study.design import cases
from analysis.study.run import METHODS
from foundation.cores import cores
from sensor.record import record

PROMISED_S = 1.0
STUDY_S = 20 * 60.0
CORES = 2
REPEATS = 3
SOME = 12
BODIES = 4


def ratios() -> Iterator[tuple[str, float, float | None]]:
    for camera in ("i400", "icx098"):
        made = bench(camera, method_names())
        taken = record(
            made.camera.with_body(1), made.protocol, made.rates, seed=1, panels=made.panels
        )
        for name in made.methods:
            times = []
            for _ in range(REPEATS):
                started = time.process_time()
                method(name)(taken)
                times.append(time.process_time() - started)
            best = min(times)
            what = f"of a second: {name} on the paper's protocol by {camera}, {best:.2f} s"
            yield what, PROMISED_S / best, 1
    every = list(cases().values())
    plan = Plan(bodies=BODIES, methods=METHODS)
    run_case(plan, every[0])
    started = time.process_time()
    for case in every[:: len(every) // SOME][:SOME]:
        run_case(plan, case)
    one = (time.process_time() - started) / SOME
    whole = one * len(every) / CORES
    what = (
        f"of 20 minutes: {len(every)} cells of the study on {CORES} cores"
        f" ({one:.2f} s a cell, {cores()} cores here)"
    )
    yield what, STUDY_S / whole, 1
