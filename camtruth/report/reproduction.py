"""The page of `camtruth reproduce`: the paper's figures and tables beside ours."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from analysis.reproduce.paper import Line, printed
from analysis.reproduce.quantization_error import ErrorCurve
from analysis.reproduce.reproduction import COMPONENTS_AT_DN, Reproduction
from analysis.reproduce.technique import total_misfit
from camtruth.report.plot import Kind, Marks, axis_over, plot
from camtruth.report.sections import Section, Table, sections_page
from camtruth.terminal import figure, rounded

HEADS = ("where", "what", "", "printed", "ours", "closed form", "unit", "")
NAMES = {"R": "Red", "G": "Green", "B": "Blue"}
MEAN = "mean pixel value / DN"


def page(made: Reproduction, command: str) -> str:
    """The page as HTML."""
    differ = sum(not line.agrees for line in made.lines)
    lead = (
        f"{len(made.lines)} figures that the paper prints, each beside ours from simulated frames:"
        f" {len(made.lines) - differ} agree, {differ} do not, and each of those says why."
    )
    return sections_page(
        title="The paper, made again",
        lead=lead,
        command=command,
        sections=(
            _quantization(made),
            _attenuation(made),
            _parameters(made),
            _shot_and_prnu(made),
            _total(made),
            _components(made),
        ),
    )


def _rows(lines: Sequence[Line], *keys: str) -> Table:
    rows = []
    for line in lines:
        if line.key not in keys:
            continue
        ours = rounded(line.ours, line.se) + (f" ± {rounded(line.se, line.se)}" if line.se else "")
        rows.append(
            (
                line.place,
                line.what,
                "" if line.channel == "all" else line.channel,
                f"{line.printed:g}",
                ours,
                figure(line.expected, 4),
                "" if line.unit == "1" else line.unit,
                "agrees" if line.agrees else line.why,
            )
        )
    return Table(heads=HEADS, rows=rows)


def _quantization(made: Reproduction) -> Section:
    both = [c.error_dn for c in made.curves] + [np.array([0.1])]
    y = axis_over(np.concatenate(both).tolist(), "measured less added / DN")
    pairs = [("Fig. 2: in the dark", False), ("Fig. 3: panel 19 under a lamp", True)]
    return Section(
        title="Quantization: Figs. 2 and 3, equations (2) and (3)",
        text=(
            "Gaussian noise is added to simulated frames, which are rounded to whole DN and"
            " measured as section III says. Fig. 3 has the light of panel 19 as it was rendered"
            " under the lamp: its gradient is that of the scene.",
        ),
        svgs=[_error_plot(title, made.curves, gradient, y) for title, gradient in pairs],
        caption="Blue: noise in time; red: noise in space; bars are one standard error. Lines: the"
        " exact expectation. Beyond 1.2 DN the column fits drive the spatial error below zero.",
        tables=[
            _rows(made.lines, "quantization_sd", "peak_temporal", "peak_spatial", "end_temporal",
                  "floor_spatial")
        ],
    )  # fmt: skip


def _error_plot(title: str, curves: Sequence[ErrorCurve], gradient: bool, y: object) -> str:
    marks = []
    for c in curves:
        if c.gradient == gradient:
            style = "b" if c.kind == "temporal" else "r"
            x = c.added_dn.tolist()
            marks.append(Marks(x=x, y=c.expected_dn.tolist(), style=style, kind="line"))
            marks.append(Marks(x=x, y=c.error_dn.tolist(), se=c.se_dn.tolist(), style=style))
    return plot(title, axis_over([0.0, 5.0], "added noise / DN"), y, marks)  # type: ignore[arg-type]


def _attenuation(made: Reproduction) -> Section:
    return Section(
        title="Demosaic: equations (4) to (7), Table V",
        text=(
            "Table V has two readings for spatial noise. Its figures are those against noise that"
            " went through the same column fit; against the noise that was added, the fit's own"
            " loss of 3 of 50 degrees of freedom comes on top.",
        ),
        tables=[
            _rows(made.lines, "demosaic_interpolated", "demosaic_sd", "table_5_temporal",
                  "table_5_spatial", "table_5_spatial_raw")
        ],
    )  # fmt: skip


def _parameters(made: Reproduction) -> Section:
    return Section(
        title="Noise parameters: equations (10), (12), (14), (16)",
        text=(
            f"A camera with the printed noise, simulated as {made.seeds} bodies under the paper's"
            " protocol and measured by the paper's technique. Where ours differs from print, the"
            " technique does not give back what went in; the closed form says so in advance.",
        ),
        tables=[
            _rows(made.lines, "fpn", "read", "shot_coefficient", "shot_offset", "prnu_slope",
                  "prnu_offset")
        ],
    )  # fmt: skip


def _shot_and_prnu(made: Reproduction) -> Section:
    svgs = []
    for key, coefficient, power, label in (
        ("shot_dn", "shot", 0.5, "SN_ph / DN"),
        ("prnu_dn", "prnu", 1.0, "PRNU × I / DN"),
    ):
        slope = "shot_coefficient" if coefficient == "shot" else "prnu_slope"
        for channel in NAMES:
            points = [
                p
                for p in made.runs.found[0].points
                if p.channel == channel and key in (p.more or {})
            ]
            x = [p.mean_dn for p in points]
            y = [float((p.more or {})[key]) for p in points]
            of = made.runs.mean[channel]
            slope_printed = printed()[slope].value[channel]
            offset_printed = printed()[f"{coefficient}_offset"].value[channel]
            marks = [
                Marks(x=x, y=y, style=channel.lower()),
                _line(of[slope], of[f"{coefficient}_offset"], power, f"{channel.lower()} fitted"),
                _line(slope_printed, offset_printed, power, "truth"),
            ]
            heights = [*y, *marks[2].y]
            svgs.append(
                plot(
                    NAMES[channel], axis_over([0.0, 130.0], MEAN), axis_over(heights, label), marks
                )
            )
    return Section(
        title="Photon shot noise and PRNU: Figs. 4 and 5",
        svgs=svgs,
        caption="Points: the first simulated body. Solid: fitted, mean over bodies. Dashed: the"
        " line that the paper prints. Above SN_ph, below PRNU.",
    )


def _line(slope: float, offset: float, power: float, style: str) -> Marks:
    grid = np.linspace(3.0, 130.0, 100)
    return Marks(
        x=grid.tolist(), y=(slope * grid**power + offset).tolist(), style=style, kind="line"
    )


def _total(made: Reproduction) -> Section:
    svgs = []
    kinds: tuple[Kind, ...] = ("dots", "rings")
    for channel in NAMES:
        points = [p for p in made.runs.found[0].points if p.channel == channel]
        values = {
            "dots": [p.rows_dn or 0.0 for p in points],
            "rings": [p.columns_dn or 0.0 for p in points],
        }
        x = [p.mean_dn for p in points]
        marks = [Marks(x=x, y=values[k], style=channel.lower(), kind=k) for k in kinds]
        y = axis_over(values["dots"], "total noise / DN")
        svgs.append(plot(NAMES[channel], axis_over([0.0, 130.0], MEAN), y, marks))
    misfit = total_misfit(made.runs)
    rows = [
        (NAMES[c], f"{100 * of['variances']:.0f} %", f"{100 * of['sds']:.0f} %")
        for c, of in misfit.items()
    ]
    return Section(
        title="Total noise and the calibrated model: Fig. 6; rows and columns",
        text=(
            "The calibrated model adds up what the technique found. The paper calls its own fit"
            " reasonable; ours misses by what the subtraction of SDs has lost on the way.",
        ),
        svgs=svgs,
        caption="Dots: by rows; rings: by columns. They lie on each other.",
        tables=[
            Table(
                heads=("channel", "misfit, components added as variances", "added as SDs"),
                rows=rows,
            ),
            _rows(made.lines, "row_column_ratio", "row_column_correlation"),
        ],
    )


def _components(made: Reproduction) -> Section:
    sets = made.components()
    largest = {name: sorted(of, key=of.__getitem__)[-3:] for name, of in sets.items()}
    same = set(largest["printed"]) == set(largest["ours"])
    verdict = (
        "N_read, PRNU and SN_ph dominate, as the paper says of its own."
        if same
        else f"The three largest are {', '.join(largest['ours'])}, other than in the paper."
    )
    rows = [
        (part, *(figure(sets[name][part]) for name in ("printed", "ours", "truth")))
        for part in sets["printed"]
    ]
    return Section(
        title="Components of noise in blue: Fig. 7",
        text=(
            f"At a mean of {COMPONENTS_AT_DN:g} DN, in DN: the printed equations, ours, and what"
            f" went into the simulated camera. {verdict}"
            f" Shot noise comes out {_ratio(sets, 'SN_ph')} of what went in, PRNU"
            f" {_ratio(sets, 'PRNU')}: both by the subtraction of SDs.",
        ),
        tables=[Table(heads=("component", "printed", "ours", "went in"), rows=rows)],
    )


def _ratio(sets: dict[str, dict[str, float]], part: str) -> str:
    share = sets["ours"][part] / sets["truth"][part]
    return f"{100 * share:.0f} %" if math.isfinite(share) else "nothing"
