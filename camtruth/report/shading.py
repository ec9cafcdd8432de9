"""The figure of shading: a rate image along both axes, the closed form, and its factors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camtruth.report.plot import HEIGHT, WIDTH, Axis, Marks, axis_over, plot
from render.rate import RateImage
from render.shading import Profile, profiles
from scenes.scene import Scene

STYLE = Path(__file__).parent / "report.css"
GAP, TOP = 14, 30
DOTS = 160
"""So many dots at most along an axis."""

WORDS = {
    "dots k": "traced",
    "line truth": "closed form",
    "line r": "1/R²",
    "line g": "cosine of the light",
    "line b": "cos⁴ of the lens",
    "line k": "barrel or rims",
}


def shading_figure(scene: Scene, image: RateImage) -> str:
    """An SVG that stands alone: shading along x and y, relative to the middle of the image."""
    known = profiles(scene, image)
    plots = [_plot(profile) for profile in known]
    rules = STYLE.read_text(encoding="utf-8")
    plain = rules.split("@media (prefers-color-scheme: dark)")[0]
    kept = (".plot text", ".plot .", ".grid", ".line", ".dots")
    marks = "\n".join(line for line in rules.splitlines() if line.startswith(kept))
    width, height = 2 * (WIDTH + GAP) + GAP, HEIGHT + GAP + TOP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}">',
        f"<style>{plain}{marks} .words {{ font: 11px system-ui, sans-serif; fill: #1c1e21 }}",
        "</style>",
        f'<rect width="{width}" height="{height}" fill="#fdfdfc"/>',
    ]
    x = GAP
    for style, words in WORDS.items():
        mark = (
            f'<path class="{style}" d="M{x} 16h20"/>'
            if "line" in style
            else f'<circle class="{style}" cx="{x + 10}" cy="16" r="3"/>'
        )
        parts.append(f'{mark}<text class="words" x="{x + 25}" y="20">{words}</text>')
        x += 40 + round(6.2 * len(words))
    for number, svg in enumerate(plots):
        left = GAP + number * (WIDTH + GAP)
        parts.append(f'<svg x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}">{svg}</svg>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def _plot(profile: Profile) -> str:
    px = profile.position_px
    factors = {
        "r": profile.distance,
        "g": profile.slant,
        "b": profile.natural,
        "k": profile.opening,
    }
    thin = slice(None, None, max(1, px.size // DOTS))
    across = Axis(low=0.0, high=float(px.size), label=f"{profile.axis} / px")
    values = [v for f in (*factors.values(), profile.total) for v in f.tolist()]
    up = axis_over(values, "relative to the middle", zero=False)
    where = "from left to right" if profile.axis == "x" else "from top to bottom"
    return plot(
        f"Shading {where}",
        across,
        up,
        [
            *(Marks(x=_list(px), y=_list(f), style=c, kind="line") for c, f in factors.items()),
            Marks(x=_list(px[thin]), y=_list(profile.measured[thin]), style="k"),
            Marks(x=_list(px), y=_list(profile.total), style="truth", kind="line"),
        ],
    )


def _list(values: NDArray[np.float64]) -> list[float]:
    return [float(value) for value in values]
