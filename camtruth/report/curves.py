"""The paper's Figs. 4 to 6: noise against mean pixel value, measured, fitted, and true.

All three figures share the axis mu_p, the mean pixel value of a panel. What went in is a function
of the light alone, so the true curves start at the black level b:

    photon shot noise   k sqrt(mu - b)           k^2 = gain in DN/e-
    PRNU                p (mu - b)
    total               sqrt(N_D^2 (read^2 + fpn^2 + shot^2 + prnu^2) + 1/12)

Equation (1) adds independent noises, so their variances add; N_D is the spatial attenuation of
Table V, because the total is measured after a polynomial fit as the spatial noise is; 1/12 is
equation (2). "Fitted" is the same with what the estimator found.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from analysis.estimators.parts.reading import N_D
from analysis.parameters import Estimate, NoiseParameters, Point
from camtruth.report.plot import Axis, Kind, Marks, axis_over, plot
from sensor.frames import Capture

Curve = Callable[[float], float]
QUANTIZATION_VARIANCE = 1 / 12
STEPS = 120
MEAN_LABEL = "mean pixel value μ<tspan dy='3' font-size='8'>p</tspan><tspan dy='-3'> / DN</tspan>"


def figures(found: NoiseParameters, truth: Mapping[str, Any], capture: Capture) -> list[Any]:
    """Figs. 4, 5 and 6: for each its title, caption and an SVG per channel."""
    demosaiced = capture.frames[0].demosaiced
    lamps = {frames.shot.label: frames.shot.light[0] for frames in capture.lit}
    channels = list(found.channels)
    sets = [
        (
            "Photon shot noise (the paper's Fig. 4)",
            "Noise in time, less rounding, demosaic and read noise.",
            "shot_dn",
            "temporal_se_dn",
            "SN<tspan dy='3' font-size='8'>ph</tspan><tspan dy='-3'> / DN</tspan>",
            _shot_curves,
        ),
        (
            "Photo-response non-uniformity (Fig. 5)",
            "Noise in space, less rounding, demosaic and offset pattern.",
            "prnu_dn",
            "spatial_se_dn",
            "PRNU × I / DN",
            _prnu_curves,
        ),
        (
            "Total noise by rows (Fig. 6)",
            "As it stands in the frames. The curves put the noise parameters into equation (1),"
            " where variances add.",
            "rows_dn",
            "rows_se_dn",
            "total noise / DN",
            _total_curves,
        ),
    ]
    drawn = []
    for title, caption, key, se_key, label, curves_of in sets:
        measured = {c: _measured(found.points, c, key, se_key, lamps) for c in channels}
        curves = {
            c: curves_of(_found(found, c), _true(truth, c), truth["black_dn"], _n_d(c, demosaiced))
            for c in channels
        }
        x = axis_over([v for m in measured.values() for v in m[0]], MEAN_LABEL)
        y = axis_over(
            [v for m in measured.values() for v in m[1]]
            + [f(x.high) for pair in curves.values() for f in pair if f is not None],
            label,
        )
        drawn.append(
            {
                "title": title,
                "caption": caption,
                "svgs": [
                    _svg(c, x, y, measured[c], curves[c], truth["black_dn"]) for c in channels
                ],
            }
        )
    return drawn


Measured = tuple[list[float], list[float], list[float], list[bool]]
Pair = tuple[Curve | None, Curve]


def _measured(
    points: Sequence[Point], channel: str, key: str, se_key: str, lamps: Mapping[str, str]
) -> Measured:
    """Means, noises and standard errors of the lit points; whether the first lamp made them."""
    x, y, se, first = [], [], [], []
    lamp = next(iter(lamps.values()), None)
    for point in points:
        figures = point.to_json()
        if point.channel == channel and key in figures and point.shot in lamps:
            x.append(point.mean_dn)
            y.append(float(figures[key]))
            se.append(float(figures.get(se_key, 0.0)))
            first.append(lamps[point.shot] == lamp)
    return x, y, se, first


def _svg(channel: str, x: Axis, y: Axis, measured: Measured, pair: Pair, black: float) -> str:
    means, noise, se, first = measured
    name = {"R": "Red", "G": "Green", "B": "Blue", "Y": "Luminance"}[channel]
    style = channel.lower()
    marks = []
    kinds: tuple[Kind, ...] = ("rings", "dots")
    for kind in kinds:
        chosen = [i for i, is_first in enumerate(first) if is_first == (kind == "dots")]
        marks.append(
            Marks(
                x=[means[i] for i in chosen],
                y=[noise[i] for i in chosen],
                se=[se[i] for i in chosen],
                style=style,
                kind=kind,
            )
        )
    fitted, true = pair
    grid = np.linspace(max(black, x.low), x.high, STEPS)
    if fitted is not None:
        marks.append(_line(grid, fitted, f"{style} fitted"))
    marks.append(_line(grid, true, "truth"))
    return plot(name, x, y, marks)


def _line(grid: np.ndarray[Any, Any], curve: Curve, style: str) -> Marks:
    return Marks(x=grid.tolist(), y=[curve(float(m)) for m in grid], style=style, kind="line")


def _found(found: NoiseParameters, channel: str) -> dict[str, float]:
    return {
        key: finding.value
        for key, finding in found.channels[channel].items()
        if isinstance(finding, Estimate)
    }


def _true(truth: Mapping[str, Any], channel: str) -> dict[str, float]:
    return {key: entry["population"] for key, entry in truth["noise"][channel].items()}


def _n_d(channel: str, demosaiced: bool) -> float:
    return N_D["spatial"][channel] if demosaiced else 1.0


def _root(coefficient: float, offset: float) -> Curve:
    return lambda mean: coefficient * math.sqrt(max(mean, 0.0)) + offset


def _straight(slope: float, offset: float) -> Curve:
    return lambda mean: slope * mean + offset


def _shot_curves(got: dict[str, float], true: dict[str, float], black: float, _: float) -> Pair:
    root = _root(true["shot_coefficient"], 0.0)
    fitted = None
    if {"shot_coefficient", "shot_offset"} <= got.keys():
        fitted = _root(got["shot_coefficient"], got["shot_offset"])
    return fitted, lambda mean: root(mean - black)


def _prnu_curves(got: dict[str, float], true: dict[str, float], black: float, _: float) -> Pair:
    fitted = None
    if {"prnu_slope", "prnu_offset"} <= got.keys():
        fitted = _straight(got["prnu_slope"], got["prnu_offset"])
    return fitted, _straight(true["prnu_slope"], -true["prnu_slope"] * black)


def _total_curves(got: dict[str, float], true: dict[str, float], black: float, n_d: float) -> Pair:
    def total(figures: dict[str, float], shot: Curve, prnu: Curve) -> Curve:
        def curve(mean: float) -> float:
            parts = (figures["read"], figures["fpn"], shot(mean), prnu(mean))
            variance = n_d**2 * sum(part**2 for part in parts)
            return math.sqrt(variance + QUANTIZATION_VARIANCE)

        return curve

    shot, true_shot = _shot_curves(got, true, black, n_d)
    prnu, true_prnu = _prnu_curves(got, true, black, n_d)
    fitted = None
    if shot is not None and prnu is not None and {"read", "fpn"} <= got.keys():
        fitted = total(got, shot, prnu)
    return fitted, total(true, true_shot, true_prnu)
