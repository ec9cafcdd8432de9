"""All cells of the study, here or on a cluster, kept as they come."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from analysis.study.cell import Plan, run_case
from analysis.study.design import cases
from foundation.jobs import run

METHODS = ("irie", "emva1288", "photon_transfer", "corrected")


def study(
    journal: Path,
    *,
    seeds: int,
    methods: Sequence[str] = METHODS,
    cells: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> list[dict[str, Any]]:
    """The rows of the study.

    Args:
        journal: file that keeps what is done; a second run goes on from there.
        seeds: bodies per cell.
        methods: estimators; a user's own as ``FILE.py:function``.
        cells: only so many, drawn at random but always the same.
        scheduler: address of a Dask scheduler; None is this process.
        progress: told the number of cells just finished.
    """
    every = cases()
    if cells is not None and cells < len(every):
        some = sorted(every, key=lambda key: zlib.crc32(key.encode()))[:cells]
        every = {key: every[key] for key in some}
    plan = Plan(bodies=seeds, methods=tuple(methods))
    found = run(
        run_case,
        every,
        shared=plan,
        scheduler=scheduler,
        journal=journal,
        question=f"gradient-quantization, {seeds} bodies, {', '.join(methods)}",
        progress=progress,
    )
    return [row for rows in found.values() for row in rows]
