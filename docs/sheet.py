"""Plots of the report side by side as one SVG that stands alone, light or dark as its reader is."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

from camtruth.report.plot import HEIGHT, WIDTH

STYLE = Path(__file__).parent.parent / "camtruth" / "report" / "report.css"
GAP = 14

MARKS = (".plot text", ".plot .", ".grid", ".line", ".dots", ".rings", ".bar")


def marks() -> str:
    """The report's rules for plots in light colours, with each variable's value in its place: not
    every program that draws an SVG knows variables.
    """
    rules = STYLE.read_text(encoding="utf-8")
    values = dict(re.findall(r"--(\w+): ([^;]+);", rules.split("@media")[0]))
    kept = "\n".join(line for line in rules.splitlines() if line.startswith(MARKS))
    return re.sub(r"var\(--(\w+)\)", lambda found: values[found[1]], kept)


def sheet(plots: Sequence[str], columns: int = 2, legend: Sequence[tuple[str, str]] = ()) -> str:
    """An SVG of plots by `camtruth.report.plot`; `legend` holds classes and words."""
    top = 30 if legend else 8
    width = columns * (WIDTH + GAP) + GAP
    height = math.ceil(len(plots) / columns) * (HEIGHT + GAP) + top
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}">',
        f"<style>{marks()} .words {{ font: 12px system-ui, sans-serif; fill: #1c1e21 }}</style>",
        f'<rect width="{width}" height="{height}" fill="#fdfdfc"/>',
    ]
    x = GAP
    for style, words in legend:
        mark = (
            f'<path class="{style}" d="M{x} 16h22"/>'
            if "line" in style
            else f'<circle class="{style}" cx="{x + 11}" cy="16" r="4"/>'
        )
        parts.append(f'{mark}<text class="words" x="{x + 28}" y="20">{words}</text>')
        x += 46 + 7 * len(words)
    for k, svg in enumerate(plots):
        row, column = divmod(k, columns)
        inner = svg.replace(
            "<svg ",
            f'<svg x="{GAP + column * (WIDTH + GAP)}" y="{top + row * (HEIGHT + GAP)}"'
            f' width="{WIDTH}" height="{HEIGHT}" ',
            1,
        )
        parts.append(inner)
    return "\n".join([*parts, "</svg>\n"])


CLASSES = ("#2a7f62", "#a9cf8b", "#f0c05a", "#d1495b")
"""Colours of a map: right to 2, 5 and 10 %, and worse."""


def class_map(
    title: str,
    x_label: str,
    y_label: str,
    x: Sequence[float],
    y: Sequence[float],
    classes: Sequence[Sequence[int]],
) -> str:
    """A map of classes 0 to 3, or -1 for no answer, as a plot of the same size as the others.

    Args:
        title, x_label, y_label: words.
        x, y: places of the columns and, upwards, of the rows; spaced evenly, whatever they are.
        classes: rows from below.
    """
    left, right, top, bottom = 52, 10, 24, 40
    across = (WIDTH - left - right) / len(x)
    up = (HEIGHT - top - bottom) / len(y)
    parts = [
        f'<svg class="plot" viewBox="0 0 {WIDTH} {HEIGHT}">',
        f'<text class="title" x="{left}" y="14">{title}</text>',
    ]
    for j, row in enumerate(classes):
        for i, level in enumerate(row):
            colour = "#c9ccd1" if level < 0 else CLASSES[level]
            parts.append(
                f'<rect x="{left + i * across:.1f}" y="{HEIGHT - bottom - (j + 1) * up:.1f}"'
                f' width="{across + 0.3:.1f}" height="{up + 0.3:.1f}" fill="{colour}"/>'
            )
    for i in range(0, len(x), max(1, len(x) // 5)):
        parts.append(
            f'<text class="tick" x="{left + (i + 0.5) * across:.1f}" y="{HEIGHT - bottom + 14}"'
            f' text-anchor="middle">{x[i]:.2g}</text>'
        )
    for j in range(0, len(y), max(1, len(y) // 6)):
        parts.append(
            f'<text class="tick" x="{left - 5}" y="{HEIGHT - bottom - (j + 0.4) * up:.1f}"'
            f' text-anchor="end">{y[j]:.2g}</text>'
        )
    middle = (top + HEIGHT - bottom) / 2
    parts.append(
        f'<text class="label" x="{(left + WIDTH - right) / 2}" y="{HEIGHT - 6}"'
        f' text-anchor="middle">{x_label}</text>'
        f'<text class="label" x="12" y="{middle}" text-anchor="middle"'
        f' transform="rotate(-90 12 {middle})">{y_label}</text>'
    )
    return "\n".join([*parts, "</svg>"])
