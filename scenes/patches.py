"""The panels of a chart: where they lie on the card, in metres, and what they reflect."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

from scenes.chart import Chart
from scenes.spectra import BAND_NM, Spectrum, reflectances, spectrum

ROWS, COLUMNS = 4, 6
"""A ColorChecker has 4 rows of 6 panels, named "1" to "24", row by row from the top left."""
PANEL_NAMES = tuple(str(number) for number in range(1, ROWS * COLUMNS + 1))
GREY_ROW = ("19", "20", "21", "22", "23", "24")

DARK, BRIGHT = "dark", "bright"
EDGE_SIZE = 0.8
"""The bright panel of an edge fills so much of the height of the card, and half of that wide."""
LIFT_M = 0.02e-3
"""How far the bright panel of an edge stands before the dark one."""


@dataclass(frozen=True, kw_only=True)
class Rectangle:
    """An upright rectangle in the plane of the chart, in m."""

    left_m: float
    bottom_m: float
    right_m: float
    top_m: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Patch:
    """A rectangular panel of one reflectance.

    Attributes:
        name: what it is called.
        x_m, y_m: its middle.
        half_width_m, half_height_m: its size.
        angle_deg: how far it is turned clockwise.
        lift_m: how far it stands before the plane of the panels.
        reflectance: against wavelength.
        clear: the upright part of it that no other panel covers.
    """

    name: str
    x_m: float
    y_m: float
    half_width_m: float
    half_height_m: float
    angle_deg: float = 0.0
    lift_m: float = 0.0
    reflectance: Spectrum
    clear: Rectangle


def flat(reflectance: float) -> Spectrum:
    """The same reflectance at all wavelengths."""
    return spectrum(BAND_NM, [reflectance, reflectance])


@functools.lru_cache(maxsize=64)
def patches(chart: Chart) -> tuple[Patch, ...]:
    """The panels of a chart that has been checked; what comes later covers what came before."""
    return {"checker": _checker, "uniform": _uniform, "edge": _edge, "wedge": _wedge}[
        chart.pattern
    ](chart)


def _upright(
    name: str, x_m: float, y_m: float, width_m: float, height_m: float, reflectance: Spectrum
) -> Patch:
    half_x, half_y = width_m / 2, height_m / 2
    return Patch(
        name=name,
        x_m=x_m,
        y_m=y_m,
        half_width_m=half_x,
        half_height_m=half_y,
        reflectance=reflectance,
        clear=Rectangle(
            left_m=x_m - half_x, bottom_m=y_m - half_y, right_m=x_m + half_x, top_m=y_m + half_y
        ),
    )


def _checker(chart: Chart) -> tuple[Patch, ...]:
    assert isinstance(chart.reflectances, str)
    assert chart.panel_m is not None
    pitch_m, result = chart.panel_m + chart.gap_m, []
    for index, curve in enumerate(reflectances(chart.reflectances)):
        row, column = divmod(index, COLUMNS)
        x_m = (column - (COLUMNS - 1) / 2) * pitch_m
        y_m = ((ROWS - 1) / 2 - row) * pitch_m
        result.append(_upright(PANEL_NAMES[index], x_m, y_m, chart.panel_m, chart.panel_m, curve))
    return tuple(result)


def _uniform(chart: Chart) -> tuple[Patch, ...]:
    (level,) = _levels(chart)
    return (_upright("1", 0.0, 0.0, chart.width_m, chart.height_m, flat(level)),)


def _wedge(chart: Chart) -> tuple[Patch, ...]:
    levels = _levels(chart)
    strip_m = (chart.width_m - (len(levels) + 1) * chart.gap_m) / len(levels)
    first_m = -chart.width_m / 2 + chart.gap_m + strip_m / 2
    height_m = chart.height_m - 2 * chart.gap_m
    return tuple(
        _upright(
            str(number + 1),
            first_m + number * (strip_m + chart.gap_m),
            0.0,
            strip_m,
            height_m,
            flat(level),
        )
        for number, level in enumerate(levels)
    )


def _edge(chart: Chart) -> tuple[Patch, ...]:
    """A dark card, and on it a bright panel whose left side passes through the middle."""
    dark, bright = _levels(chart)
    angle = math.radians(chart.edge_deg)
    half_height_m = EDGE_SIZE * chart.height_m / 2
    half_width_m = half_height_m / 2
    lean_m, drop_m = half_height_m * math.sin(angle), 2 * half_width_m * math.sin(angle)
    reach_m = half_height_m * math.cos(angle)
    card = Rectangle(
        left_m=-chart.width_m / 2,
        bottom_m=-chart.height_m / 2,
        right_m=-lean_m,
        top_m=chart.height_m / 2,
    )
    behind = _upright(DARK, 0.0, 0.0, chart.width_m, chart.height_m, flat(dark))
    before = Patch(
        name=BRIGHT,
        x_m=half_width_m * math.cos(angle),
        y_m=-half_width_m * math.sin(angle),
        half_width_m=half_width_m,
        half_height_m=half_height_m,
        angle_deg=chart.edge_deg,
        lift_m=LIFT_M,
        reflectance=flat(bright),
        clear=Rectangle(
            left_m=lean_m,
            bottom_m=-reach_m,
            right_m=2 * half_width_m * math.cos(angle) - lean_m,
            top_m=reach_m - drop_m,
        ),
    )
    return (
        Patch(
            name=DARK,
            x_m=behind.x_m,
            y_m=behind.y_m,
            half_width_m=behind.half_width_m,
            half_height_m=behind.half_height_m,
            reflectance=behind.reflectance,
            clear=card,
        ),
        before,
    )


def _levels(chart: Chart) -> tuple[float, ...]:
    assert not isinstance(chart.reflectances, str)
    return chart.reflectances
