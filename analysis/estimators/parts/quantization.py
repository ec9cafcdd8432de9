"""Quantization error N_Q: how far rounding moves a measured noise from the noise that was there.

The curves of Figs. 2 and 3 of Irie et al., simulated when they are first asked for: Gaussian
noise of known SD on an even panel or on a point lamp's gradient, rounded to whole DN and measured
like any panel. The curves include what the measurement itself does: the SD of few frames is low on
average, and each column's parabola takes 3 of its degrees of freedom.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.panel_noise import Floats, measure_panel

Kind = Literal["temporal", "spatial"]

LEVEL_DN = 120
"""Mean of the simulated panel: a whole number, as a dark frame's pedestal is, and far above 0."""

SLOPE_DN_PER_PX = 0.15
"""Gradient of the simulated point lamp at the panel's centre: 6 % of panel 19 over 50 pixels. Our
assumption: the paper does not give its own. Any slope that sweeps a few codes gives its curves."""

DIRECTION = (0.9, 0.436)
"""Down and across: a lamp above the camera and a little aside, so that columns differ in level."""

PANEL_PX = 50
FRAMES = 100
"""The paper's panel and stack."""

ADDED_DN: Floats = np.concatenate([np.arange(0, 1.5, 0.05), np.arange(1.5, 5.01, 0.25)])
"""Added noise at which the curves are simulated; the paper's range, 0 to 5."""

KEY = 0x1B1E
"""Key of the Philox generator behind the curves: the same everywhere, always."""


@dataclass(frozen=True, kw_only=True, eq=False)
class QuantizationCurve:
    """Measured noise against added noise, in DN, and the error that is their difference."""

    added_dn: Floats
    measured_dn: Floats

    @property
    def error_dn(self) -> Floats:
        """N_Q: measured less added, the ordinate of Figs. 2 and 3."""
        return self.measured_dn - self.added_dn

    @property
    def floor_dn(self) -> float:
        """The least noise that can be measured; what lies at or below it shows only rounding."""
        return float(self.measured_dn[0])

    def noise_before(self, measured_dn: float) -> tuple[float, float]:
        """The added noise behind a measured one, and its change per change of the measured one.

        N_Q at that point is ``measured_dn`` less the first figure. Beyond the curve's end the
        ratio of added to measured noise is kept; at or below its floor the answer is 0.
        """
        rising = np.maximum.accumulate(self.measured_dn)
        keep = np.concatenate([np.diff(rising) > 0, [True]])
        x, y = rising[keep], self.added_dn[keep]
        if measured_dn >= x[-1]:
            ratio = float(y[-1] / x[-1])
            return measured_dn * ratio, ratio
        if measured_dn <= self.floor_dn:
            return 0.0, 0.0
        k = int(np.searchsorted(x, measured_dn, side="right")) - 1
        slope = float((y[k + 1] - y[k]) / (x[k + 1] - x[k]))
        return float(y[k]) + slope * (measured_dn - float(x[k])), slope


def curve(
    kind: Kind,
    *,
    gradient: bool,
    rows: int = PANEL_PX,
    frames: int = FRAMES,
    slope_dn_per_px: float = SLOPE_DN_PER_PX,
) -> QuantizationCurve:
    """The curve for noise in time or in space, without or with a lighting gradient.

    Args:
        kind: "temporal" noise is new in every frame; "spatial" noise is one fixed pattern.
        gradient: False for Fig. 2 (dark frames), True for Fig. 3 (a lit panel).
        rows: samples in a column of the panel; a parabola costs 3 of them.
        frames: length of the stack that was measured; beyond 100 it makes no difference.
        slope_dn_per_px: the gradient at the panel's centre.
    """
    temporal, spatial = _curves(rows, min(frames, FRAMES), slope_dn_per_px if gradient else 0.0)
    return temporal if kind == "temporal" else spatial


def point_lamp(rows: int, columns: int, slope_dn_per_px: float) -> Floats:
    """Level in DN of a panel under a point lamp: 1/R^2, with a given slope at the centre.

    R is the distance from the lamp's foot in pixels, 2 level / slope at the centre.
    """
    y = np.arange(rows) - (rows - 1) / 2
    x = np.arange(columns) - (columns - 1) / 2
    towards = DIRECTION[0] * y[:, None] + DIRECTION[1] * x[None, :]
    return np.asarray(LEVEL_DN / (1 - towards * slope_dn_per_px / (2 * LEVEL_DN)) ** 2)


@functools.cache
def _curves(
    rows: int, frames: int, slope_dn_per_px: float
) -> tuple[QuantizationCurve, QuantizationCurve]:
    """Both curves from the same draws, scaled to each SD, so that they are smooth."""
    columns = max(4, PANEL_PX * PANEL_PX // rows)
    panels = FRAMES // frames
    level = point_lamp(rows, columns, slope_dn_per_px)
    generator = np.random.Generator(np.random.Philox(KEY))
    draws = generator.standard_normal((panels * frames, rows, columns), dtype=np.float32)
    found = np.array([_measure(level, float(sigma) * draws, panels) for sigma in ADDED_DN])
    found.setflags(write=False)
    added = ADDED_DN.copy()
    added.setflags(write=False)
    return (
        QuantizationCurve(added_dn=added, measured_dn=found[:, 0]),
        QuantizationCurve(added_dn=added, measured_dn=found[:, 1]),
    )


def _measure(level: Floats, noise: NDArray[np.float32], panels: int) -> tuple[float, float]:
    """Temporal noise of the stacks, and the spatial noise that each frame has as a fixed pattern.

    The column measure of a frame is the spatial measure of a stack that repeats it, so every
    frame is one more draw of a pattern.
    """
    dn = np.rint(level + noise).clip(0, 255).astype(np.uint8)
    found = [measure_panel(stack, 255) for stack in np.split(dn, panels)]
    return (
        float(np.mean([panel.temporal_dn for panel in found])),
        float(np.mean([panel.columns_dn for panel in found])),
    )
