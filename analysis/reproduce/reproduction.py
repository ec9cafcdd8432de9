"""All of it: every figure, equation and table of the paper, made from simulated frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.reproduce import attenuation, technique
from analysis.reproduce.paper import Line, compare, printed
from analysis.reproduce.quantization_error import (
    ErrorCurve,
    error_curve,
    level_of,
    pedestal,
)
from analysis.reproduce.technique import Rates, Runs
from foundation.panel import Panel
from sensor.camera import Camera
from sensor.protocol import Protocol

FORMAT = "camtruth-reproduce/1"
PANEL = "19"
"""The panel of Figs. 2 and 3."""

LEVEL_DN = 120.0
"""Its mean in Fig. 3: what the camera gives in green at full level."""

COMPONENTS_AT_DN = 100.0
"""The level at which Fig. 7 is told; the paper draws it up to 130."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reproduction:
    """The paper made again.

    Attributes:
        curves: Figs. 2 and 3, temporal and spatial.
        lines: every printed figure beside ours.
        runs: the technique on simulated captures.
        seeds: how many bodies.
    """

    curves: tuple[ErrorCurve, ...]
    lines: tuple[Line, ...]
    runs: Runs
    seeds: int

    def to_json(self) -> dict[str, Any]:
        """The document of `reproduce --json`."""
        return {
            "format": FORMAT,
            "seeds": self.seeds,
            "lines": [line.to_json() for line in self.lines],
            "curves": [curve.to_json() for curve in self.curves],
            "technique": technique.to_json(self.runs),
            "components": self.components(),
            "total_misfit": technique.total_misfit(self.runs),
        }

    def components(self) -> dict[str, dict[str, float]]:
        """Fig. 7, blue: printed equations, ours, and what went in, in DN at one level."""
        paper = {key: printed()[key].value["B"] for key in technique.COMPARED}
        sets = {"printed": paper, "ours": self.runs.mean["B"], "truth": self.runs.truth["B"]}
        return {name: technique.components(of, COMPONENTS_AT_DN) for name, of in sets.items()}


def reproduce(
    camera: Camera,
    protocol: Protocol,
    rates: Rates,
    panels: Sequence[Panel],
    *,
    seeds: Sequence[int],
    progress: Callable[[int], None] = lambda seeds: None,
) -> Reproduction:
    """Make everything.

    Args:
        camera: a camera with the paper's noise.
        protocol: the paper's shots.
        rates: light by lamp, as rendered; the last lamp's gradient makes Fig. 3.
        panels: the grey panels.
        seeds: two or more camera bodies.
        progress: told the number of bodies just finished.
    """
    panel = next(p for p in panels if p.name == PANEL)
    green = np.asarray(rates[protocol.lamps[-1]][..., 1], dtype=np.float64)
    lit = level_of(green, panel, LEVEL_DN)
    curves = tuple(
        error_curve(kind, level, gradient=gradient, seed=seeds[0])
        for gradient, level in ((False, pedestal()), (True, lit))
        for kind in ("temporal", "spatial")
    )
    runs = technique.run(camera, protocol, rates, panels, seeds=seeds, progress=progress)
    lines = (
        *_curve_lines(curves),
        *attenuation.equations(),
        *attenuation.table_5(seeds[0]),
        *technique.lines(runs),
    )
    order = list(printed())
    return Reproduction(
        curves=curves,
        lines=tuple(sorted(lines, key=lambda line: order.index(line.key))),
        runs=runs,
        seeds=len(seeds),
    )


def _curve_lines(curves: Sequence[ErrorCurve]) -> tuple[Line, ...]:
    """What the text says of Figs. 2 and 3, read off the curves."""
    by = {(c.kind, c.gradient): c for c in curves}
    lines = []
    for kind in ("temporal", "spatial"):
        own = by[kind, False]
        top = int(np.argmax(own.error_dn))
        best = float(own.added_dn[int(np.argmax(own.expected_dn))])
        lines.append(compare(f"peak_{kind}", float(own.added_dn[top]), 0.0, expected=best))
    dark, lit = by["temporal", False], by["spatial", True]
    two = int(np.argmin(np.abs(dark.added_dn - 2)))
    lines.append(
        compare(
            "end_temporal",
            float(dark.error_dn[two]),
            float(dark.se_dn[two]),
            expected=float(dark.expected_dn[two]),
        )
    )
    lines.append(
        compare(
            "floor_spatial",
            float(lit.error_dn[0]),
            float(lit.se_dn[0]),
            expected=float(lit.expected_dn[0]),
            why="Column fits take 3 of 50 degrees of freedom of the rounding error too.",
        )
    )
    return tuple(lines)
