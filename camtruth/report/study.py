"""The page of `camtruth study gradient-quantization`: figures to explore, findings, guidance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from analysis.study.bench import FRAMES
from analysis.study.findings import bits_for
from camtruth.report.sections import Section, Table, sections_page
from camtruth.report.study_figures import against_noise, against_ramp, parallel

Rows = Sequence[Mapping[str, Any]]
CAMERAS_DN8 = (0.1, 0.35, 1.0)
"""Read noise of the cameras that guidance is for, in DN of 8 bits."""


def page(rows: Rows, found: Mapping[str, Any], command: str) -> str:
    """The page as HTML."""
    lead = (
        f"{found['cells']} cells of {found['seeds']} bodies, {found['rows']} figures, each beside"
        " its closed form: what gradient, rounding and the lamp make of every estimator."
    )
    figures = [
        ("Bias against noise per step", NOISE, against_noise(rows)),
        ("PRNU against the ramp", RAMP, against_ramp(rows)),
        ("All factors at once", ALL, parallel(rows)),
    ]
    sections = [Section(title="Findings", text=found["findings"])]
    for k, (title, text, figure) in enumerate(figures):
        if figure is not None:
            html = figure.to_html(full_html=False, include_plotlyjs=k == 0, div_id=f"figure-{k}")
            sections.append(Section(title=title, text=(text,), interactive=html))
    sections.append(
        Section(
            title="Guidance",
            text=(GUIDANCE,),
            tables=[bits_table(found["guidance"]), frames_table(found["guidance"])],
        )
    )
    return sections_page(
        title="Lighting gradient against quantization",
        lead=lead,
        command=command,
        sections=sections,
    )


NOISE = (
    "Median over cells of the bias relative to the truth, solid, with its closed form, dashed."
    " Choose the parameter above the figure; click a name to hide or show an estimator."
)
RAMP = (
    "Every cell of green once. The line is r / √12 added to PRNU as a variance: what a ramp is"
    " worth to an estimator that does not take it off."
)
ALL = "Drag along an axis to keep some cells; drag an axis to move it. Green, read noise."
GUIDANCE = (
    "Bits: the fewest at which the parameter is right to 2 % for a camera of that read noise,"
    " in DN of 8 bits (0.1, 0.35, 1); a dash where none of 8, 10 and 12 will do. Frames: for 1 % of"
    f" scatter of the gain in the worst colour, from the scatter at {FRAMES} frames, by electrons"
    " per DN of 8 bits. Patterns are another matter: their scatter is that of the sites, and more"
    " frames do not help."
)


def bits_table(guidance: Rows) -> Table:
    """Bits for each gradient, lamp and estimator."""
    rows = []
    for of in guidance:
        cells = []
        for key in ("read", "gain", "fpn", "prnu"):
            bits = [bits_for(of["least_noise_steps"][key], dn8) for dn8 in CAMERAS_DN8]
            cells.append(" / ".join("–" if b is None else str(b) for b in bits))
        rows.append((of["place"], f"{of['rise']:.0%}", of["lamp"], of["method"], *cells))
    heads = ("gradient", "rise", "lamp", "method", "read", "gain", "fpn", "prnu")
    return Table(heads=heads, rows=rows)


def frames_table(guidance: Rows) -> Table:
    """Frames for each gradient and lamp."""
    own = [of for of in guidance if of["method"] in ("corrected", "photon_transfer")]
    electrons = list(own[0]["frames"]) if own else []
    rows = [
        (
            of["place"],
            of["lamp"],
            of["method"],
            *("–" if of["frames"][e] is None else str(of["frames"][e]) for e in electrons),
        )
        for of in own
    ]
    heads = ("gradient", "lamp", "method", *(f"frames at {e} e-/DN" for e in electrons))
    return Table(heads=heads, rows=rows)
