"""The paper's four noise figures of a panel, 100 frames: projections against polyfit in loops.

The loop fits every row and every column of every frame by `numpy.polyfit`, as the paper's text
reads. It is timed on a few frames and scaled, because all of them take minutes.
"""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.panel_noise import measure_panel

FRAMES, SIDE = 100, 50
TIMED = 5
REPEATS = 5


def ratios() -> Iterator[tuple[str, float, float | None]]:
    stack = np.random.default_rng(1).normal(120, 5, (FRAMES, SIDE, SIDE)).round().astype(np.uint8)
    started = time.perf_counter()
    rows, columns = _by_loops(stack[:TIMED])
    slow = (time.perf_counter() - started) * FRAMES / TIMED
    times = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        measure_panel(stack, 255)
        times.append(time.perf_counter() - started)
    ours = measure_panel(stack[:TIMED], 255)
    assert np.allclose([ours.rows_dn, ours.columns_dn], [rows, columns], rtol=1e-3)
    fast = min(times)
    what = f"faster analysis of 100 frames: {1e3 * fast:.1f} ms against {slow:.2f} s"
    yield what, slow / fast, 50


def _by_loops(stack: NDArray[np.uint8]) -> tuple[float, float]:
    """Total noise by row and by column, as the paper's section III.3 reads."""
    stack.std(axis=0, ddof=1).mean()
    place = np.arange(SIDE)
    mean = stack.mean(axis=0)
    np.std([c - np.polyval(np.polyfit(place, c, 2), place) for c in mean.T], ddof=1)
    figures = []
    for lines in (stack, stack.transpose(0, 2, 1)):
        noise = [
            np.std([line - np.polyval(np.polyfit(place, line, 2), place) for line in frame], ddof=1)
            for frame in lines
        ]
        figures.append(float(np.mean(noise)))
    return figures[0], figures[1]
