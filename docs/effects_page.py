"""The catalogue page, docs/effects.md: a table and a section for each effect, from the code."""

from __future__ import annotations

import inspect
import itertools

from sensor.catalogue import catalogue, to_json
from sensor.effect import Effect, Stage

HEAD = """\
# The catalogue of effects

Written by `make docs` from `sensor/effects/`; `camtruth effects NAME` says the same. Each figure
shows a frame without the effect, the same frame with it, their difference, amplified, and what the
effect does to a statistic of many frames. The camera of the figures is that of equation (1) at
66 e-/DN, its chart in the light of the closed form; some effects are shown stronger than by
default, and then the figure says so.
"""


def catalogue_page() -> str:
    """The whole page."""
    sections = []
    for stage, kinds in itertools.groupby(catalogue().values(), key=lambda kind: kind.stage):
        sections.append(f"\n## {stage.value.capitalize()}\n\n{_unit(stage)}\n")
        sections.extend(_section(kind) for kind in kinds)
    return HEAD + "\n" + _table() + "".join(sections)


def _table() -> str:
    """One line for each parameter."""
    lines = [
        "| effect | stage | parameter | unit | default | least | most | source |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for effect in to_json()["effects"]:
        first = [f"`{effect['name']}`", effect["stage"]]
        for p in effect["parameters"] or [None]:
            figures = (
                [f"`{p['name']}`", p["unit"], *(f"{p[k]:g}" for k in ("default", "min", "max"))]
                if p
                else ["", "", "", "", ""]
            )
            reference = effect["reference"].replace("|", "\\|") if first[0] else ""
            lines.append("| " + " | ".join([*first, *figures, reference]) + " |")
            first = ["", ""]
    return "\n".join(lines) + "\n"


def _unit(stage: Stage) -> str:
    return f"The signal there: {stage.quantity.value}."


def _section(kind: type[Effect]) -> str:
    figure = f"![without, with, difference, statistic](figures/effects/{kind.name}.png)"
    base = " (equation 1)" if kind.base else ""
    text = inspect.cleandoc(kind.__doc__ or "")
    return f"\n### {kind.name}{base}\n\n{text}\n\n{figure}\n"
