"""Plots as SVG: points with error bars and lines over two linear axes, coloured by the page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

Kind = Literal["dots", "rings", "line"]

WIDTH, HEIGHT = 330, 236
LEFT, RIGHT, TOP, BOTTOM = 46, 10, 24, 40
TICKS = 5
"""Roughly how many ticks an axis has."""


@dataclass(frozen=True, kw_only=True)
class Marks:
    """Something to draw: points, or a line through them.

    Attributes:
        x, y: coordinates in the units of the axes.
        style: CSS class that colours and dashes it.
        se: standard errors of `y`, drawn as bars of one standard error where longer than the mark.
        kind: ``dots`` filled, ``rings`` hollow, or a ``line``.
    """

    x: Sequence[float]
    y: Sequence[float]
    style: str
    se: Sequence[float] | None = None
    kind: Kind = "dots"


@dataclass(frozen=True, kw_only=True)
class Axis:
    """An axis from `low` to `high`, with its label and unit."""

    low: float
    high: float
    label: str

    def ticks(self) -> list[float]:
        """Round figures inside the axis."""
        step = _round_step((self.high - self.low) / TICKS)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [k * step for k in range(first, last + 1)]


def axis_over(values: Sequence[float], label: str, *, zero: bool = True) -> Axis:
    """An axis that holds all values with a little room, and zero if asked."""
    finite = [v for v in values if math.isfinite(v)] or [0.0, 1.0]
    low, high = min(finite), max(finite)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    room = 0.06 * ((high - low) or 1.0)
    return Axis(low=low - room if low < 0 or not zero else low, high=high + room, label=label)


def plot(title: str, x: Axis, y: Axis, marks: Sequence[Marks]) -> str:
    """An SVG of the marks; the page's style sheet gives the colours."""
    parts = [
        f'<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{title}">',
        f'<text class="title" x="{LEFT}" y="14">{title}</text>',
        *_grid(x, y),
    ]
    for mark in marks:
        parts += _draw(mark, x, y)
    return "\n".join([*parts, "</svg>"])


def _across(axis: Axis, value: float) -> float:
    return LEFT + (value - axis.low) / (axis.high - axis.low) * (WIDTH - LEFT - RIGHT)


def _up(axis: Axis, value: float) -> float:
    return HEIGHT - BOTTOM - (value - axis.low) / (axis.high - axis.low) * (HEIGHT - TOP - BOTTOM)


def _grid(x: Axis, y: Axis) -> list[str]:
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    parts = []
    for tick in x.ticks():
        at = _across(x, tick)
        parts.append(f'<path class="grid" d="M{at:.1f} {TOP}V{bottom}"/>')
        parts.append(
            f'<text class="tick" x="{at:.1f}" y="{bottom + 15}" text-anchor="middle">{tick:g}'
            "</text>"
        )
    for tick in y.ticks():
        at = _up(y, tick)
        zero = " zero" if tick == 0 else ""
        parts.append(f'<path class="grid{zero}" d="M{LEFT} {at:.1f}H{right}"/>')
        parts.append(
            f'<text class="tick" x="{LEFT - 6}" y="{at + 3.5:.1f}" text-anchor="end">'
            f"{_short(tick)}</text>"
        )
    middle = (TOP + bottom) / 2
    parts.append(
        f'<text class="label" x="{(LEFT + right) / 2}" y="{HEIGHT - 6}" text-anchor="middle">'
        f"{x.label}</text>"
    )
    parts.append(
        f'<text class="label" x="12" y="{middle}" text-anchor="middle"'
        f' transform="rotate(-90 12 {middle})">{y.label}</text>'
    )
    return parts


def _draw(mark: Marks, x: Axis, y: Axis) -> list[str]:
    points = [
        (_across(x, a), _up(y, b))
        for a, b in zip(mark.x, mark.y, strict=True)
        if math.isfinite(a) and math.isfinite(b)
    ]
    if mark.kind == "line":
        path = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
        return [f'<polyline class="line {mark.style}" points="{path}"/>']
    radius = 2.6
    parts = []
    scale = (HEIGHT - TOP - BOTTOM) / (y.high - y.low)
    for (a, b), se in zip(points, mark.se or [0.0] * len(points), strict=True):
        half = se * scale
        if half > radius:
            parts.append(
                f'<path class="bar {mark.style}" d="M{a:.1f} {b - half:.1f}V{b + half:.1f}"/>'
            )
        parts.append(
            f'<circle class="{mark.kind} {mark.style}" cx="{a:.1f}" cy="{b:.1f}" r="{radius}"/>'
        )
    return parts


def _round_step(rough: float) -> float:
    """The next larger of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(rough))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= rough * (1 - 1e-9))


def _short(tick: float) -> str:
    return f"{tick:.6g}".replace("-", "−")
