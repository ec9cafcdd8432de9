"""The study's figures for people to explore, in plotly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from analysis.study.design import NOISE_STEPS
from analysis.study.findings import KEYS, WORDS, relative, select

Rows = Sequence[Mapping[str, Any]]
COLOURS = {
    "irie": "#c44e52",
    "emva1288": "#8172b3",
    "photon_transfer": "#dd8452",
    "corrected": "#2a7f62",
}
OTHER = "#4c72b0"
LAYOUT: Mapping[str, Any] = {
    "template": "plotly_white",
    "height": 460,
    "margin": {"l": 70, "r": 20, "t": 80, "b": 60},
    "legend": {"orientation": "h", "y": -0.2},
}


def against_noise(rows: Rows) -> Any:
    """Bias of each parameter by estimator against noise per step, closed form dashed."""
    figure = go.Figure()
    names = list(dict.fromkeys(row["method"] for row in rows))
    shown: list[str] = []
    for key in KEYS:
        for name in names:
            own = select(rows, method=name, parameter=key)
            for column, dash in (("bias", "solid"), ("predicted_bias", "dash")):
                by_noise = [relative(select(own, noise_steps=s), column) for s in NOISE_STEPS]
                y = [100 * float(np.median(v)) if v.size else None for v in by_noise]
                figure.add_trace(
                    go.Scatter(
                        x=list(NOISE_STEPS),
                        y=y,
                        name=name + ("" if column == "bias" else ", closed form"),
                        mode="lines+markers" if column == "bias" else "lines",
                        line={"color": COLOURS.get(name, OTHER), "dash": dash},
                        legendgroup=name,
                        visible=key == KEYS[0],
                    )
                )
                shown.append(key)
    figure.update_layout(
        **LAYOUT,
        updatemenus=[_menu({WORDS[key]: [key == k for k in shown] for key in KEYS})],
    )
    figure.update_xaxes(type="log", title="read noise / steps", tickvals=list(NOISE_STEPS))
    figure.update_yaxes(title="bias / % of the truth")
    return figure


def against_ramp(rows: Rows) -> Any:
    """PRNU as read against the ramp's rise; None where no estimator gave any."""
    figure = go.Figure()
    known = [
        row
        for row in select(rows, parameter="prnu", channel="G", blur_px=0.0)
        if row["estimate"] is not None
    ]
    if not known:
        return None
    for name in dict.fromkeys(row["method"] for row in known):
        own = select(known, method=name)
        figure.add_trace(
            go.Scatter(
                x=[100 * r["rise_dn8"] / r["level_dn8"] for r in own],
                y=[100 * r["estimate"] for r in own],
                text=[
                    f"{r['place']}, {r['lamp']}, {r['bits']} bits,"
                    f" {r['electrons_per_dn8']:g} e-/DN, noise {r['noise_steps']:g} steps"
                    for r in own
                ],
                name=name,
                mode="markers",
                marker={"color": COLOURS.get(name, OTHER), "size": 6, "opacity": 0.6},
            )
        )
    truth = 100 * known[0]["truth"]
    rise = np.geomspace(0.3, 80, 60)
    figure.add_trace(
        go.Scatter(
            x=rise.tolist(),
            y=np.sqrt(truth**2 + rise**2 / 12).tolist(),
            name="√(PRNU² + r²/12)",
            mode="lines",
            line={"color": "#333333", "dash": "dash"},
        )
    )
    figure.update_layout(**LAYOUT)
    figure.update_xaxes(type="log", title="rise of the light over the panel / % of its mean")
    figure.update_yaxes(type="log", title="PRNU as read / %")
    return figure


def parallel(rows: Rows) -> Any:
    """Factors and bias as parallel axes, an estimator at a time."""
    figure = go.Figure()
    names = list(dict.fromkeys(row["method"] for row in rows))
    for name in names:
        own = [
            row
            for row in select(rows, method=name, parameter="read", channel="G")
            if row["bias"] is not None
        ]
        bias = [100 * r["bias"] / r["truth"] for r in own]
        axes = [
            ("rise / DN", [r["rise_dn8"] for r in own]),
            ("bits", [r["bits"] for r in own]),
            ("electrons / DN", [r["electrons_per_dn8"] for r in own]),
            ("noise / steps", [r["noise_steps"] for r in own]),
            ("defocus / px", [r["blur_px"] for r in own]),
            ("read noise bias / %", bias),
        ]
        figure.add_trace(
            go.Parcoords(
                line={"color": bias, "colorscale": "RdBu", "cmid": 0, "showscale": True},
                dimensions=[{"label": label, "values": values} for label, values in axes],
                name=name,
                visible=name == names[0],
            )
        )
    figure.update_layout(
        **{**LAYOUT, "margin": {"l": 70, "r": 70, "t": 130, "b": 40}},
        updatemenus=[_menu({name: [name == n for n in names] for name in names})],
    )
    return figure


def _menu(choices: Mapping[str, Sequence[bool]]) -> dict[str, Any]:
    return {
        "buttons": [
            {"label": label, "method": "update", "args": [{"visible": list(visible)}]}
            for label, visible in choices.items()
        ],
        "x": 0,
        "xanchor": "left",
        "y": 1.28,
    }
