"""The figures of docs/bias.md: sweeps, domain maps, failing cases."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.bias.domain import KEYS, LIMITS, figures, true_figures
from analysis.bias.prediction import Make
from analysis.bias.sweeps import SWEEPS
from camtruth.report.plot import Axis, Marks, axis_over, plot
from docs.sheet import class_map, sheet

Document = Mapping[str, Any]
NAMES = {"read": "read noise", "fpn": "FPN", "shot_coefficient": "shot coefficient"}
NAMES |= {"prnu_slope": "PRNU"}
CHANNELS = (("line r", "red"), ("line g", "green"), ("line b", "blue"))
SHOWN = ("frames", "size", "read", "fpn", "black", "level", "exposure", "gradient", "step")
LOG = ("frames", "read", "fpn", "step", "gradient", "level", "exposure")


def sweep_figure(name: str, cells: Document) -> str:
    """Bias of the four parameters against one quantity: simulated and closed form."""
    sweep = SWEEPS[name]
    settings = sweep.settings()
    known = [(v, s) for v, s in zip(sweep.values, settings, strict=True) if s.slug in cells]
    places = [float(v) for v, _ in known]
    log = name in LOG and min(places) > 0
    x = [float(np.log10(v)) for v in places] if log else places
    low, high = min(x), max(x)
    room = 0.05 * (high - low)
    label = ("log10 of " if log else "") + sweep.label
    plots = []
    for key in KEYS:
        marks = []
        every = []
        for channel in "RGB":
            of = [cells[s.slug]["techniques"]["printed"][channel][key] for _, s in known]
            true = [cells[s.slug]["truth"][channel][key] for _, s in known]
            bias = [100 * b["bias"] / t for b, t in zip(of, true, strict=True)]
            se = [100 * b["se"] / t for b, t in zip(of, true, strict=True)]
            ahead = [100 * b["expected"] / t for b, t in zip(of, true, strict=True)]
            style = channel.lower()
            marks.append(Marks(x=x, y=ahead, style=style, kind="line"))
            marks.append(Marks(x=x, y=bias, se=se, style=style))
            every += bias
        axis = Axis(low=low - room, high=high + room, label=label)
        plots.append(plot(NAMES[key], axis, axis_over(every, "bias / % of the truth"), marks))
    return sheet(plots, legend=[*CHANNELS, ("dots k", "simulated; lines: closed form")])


def domain_figure() -> str:
    """Where the technique holds: four maps around the i400's red, without clipping."""
    base = {"gain": 0.045, "read": 1.612, "fpn": 0.3, "prnu": 0.0104, "black": 6.0}
    axes = {
        "read": ("read", np.geomspace(0.2, 5, 12), "black", np.linspace(0, 10, 9)),
        "fpn": ("read", np.geomspace(0.2, 5, 12), "fpn", np.geomspace(0.1, 4, 9)),
        "shot_coefficient": ("read", np.geomspace(0.2, 5, 12), "gain", np.geomspace(0.01, 1, 9)),
        "prnu_slope": ("fpn", np.geomspace(0.1, 4, 12), "prnu", np.geomspace(0.002, 0.05, 9)),
    }
    words = {"read": "read noise / DN", "fpn": "FPN / DN", "gain": "gain / (DN/e-)"}
    words |= {"black": "black level / DN", "prnu": "PRNU"}
    maps = []
    for key, (across, x, up, y) in axes.items():
        classes = [[_class(base | {across: float(a), up: float(b)}, key) for a in x] for b in y]
        maps.append(class_map(NAMES[key], words[across], words[up], list(x), list(y), classes))
    return sheet(maps)


def _class(values: Mapping[str, float], key: str) -> int:
    make = Make(channel="R", **values)  # type: ignore[arg-type]
    found = figures(make, exposures_s=(0.03,), levels_dn=(8.0, 20.0, 45.0, 80.0, 120.0), frames=100)
    true = true_figures(make)
    off = abs(found[key] / true[key] - 1)
    return sum(off > limit for limit in LIMITS)


def tell_figure(rows: list[dict[str, float]]) -> str:
    """Where 8-bit dark frames tell the corrected estimator their noise, and how well."""
    noises = sorted({r["noise"] for r in rows})
    blacks = sorted({r["black"] for r in rows})
    by_place = {(r["noise"], r["black"]): r for r in rows}

    def of(noise: float, black: float) -> int:
        r = by_place[noise, black]
        if r["told"] < 0.5:
            return -1
        return sum(abs(r["ratio"] - 1) > limit for limit in LIMITS)

    classes = [[of(noise, black) for noise in noises] for black in blacks]
    title = "read noise by the corrected estimator"
    return sheet(
        [class_map(title, "read noise / DN", "black level / DN", noises, blacks, classes)], 1
    )


def ramp_figure(rows: list[dict[str, Any]]) -> str:
    """PRNU as read against the ramp of the light."""
    x = [100 * r["rise"] for r in rows]
    styles = {"photon_transfer": "r", "emva1288": "b", "irie": "k", "corrected": "g"}
    marks = [
        Marks(x=x, y=[100 * r["read"].get(name, np.nan) for r in rows], style=style)
        for name, style in styles.items()
    ]
    grid = np.linspace(0, max(x), 60)
    truth = 100 * rows[0]["truth"]
    ramp = np.sqrt(truth**2 + grid**2 / 12)
    marks.append(Marks(x=grid.tolist(), y=ramp.tolist(), style="truth", kind="line"))
    y = [100 * v for r in rows for v in r["read"].values()]
    axis = Axis(low=0, high=1.05 * max(x), label="rise of the light over the panel / %")
    legend = [(f"dots {style}", name) for name, style in styles.items()]
    title = "A ramp read as PRNU"
    return sheet([plot(title, axis, axis_over(y, "PRNU as read / %"), marks)], 2, legend)


def rounding_figure(rows: list[dict[str, float]]) -> str:
    """Noise told by variance less 1/12 of frames rounded once, twice, and truncated."""
    x = [r["noise"] for r in rows]
    plots = []
    for how in ("plain", "likelihood"):
        marks = []
        for name, style in (("once", "g"), ("twice", "r"), ("truncated", "b")):
            y = [
                100 * (r[f"{name} {how}"] / r["noise"] - 1) if r[f"{name} {how}"] else np.nan
                for r in rows
            ]
            marks.append(Marks(x=x, y=y, style=style))
        every = [v for m in marks for v in m.y]
        title = {"plain": "Variance less 1/12", "likelihood": "Likelihood of codes"}[how]
        axis = Axis(low=0, high=1.05 * max(x), label="noise / DN")
        plots.append(plot(title, axis, axis_over(every, "bias of the noise / %"), marks))
    legend = [("dots g", "rounded once"), ("dots r", "twice"), ("dots b", "truncated")]
    return sheet(plots, 2, legend)
