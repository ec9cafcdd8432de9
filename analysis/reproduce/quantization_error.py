"""Figs. 2 and 3: how rounding changes measured noise, without and with a lamp's gradient.

Frames are simulated: noise of known SD on a dark pedestal, or on panel 19 as it was rendered under
a lamp, rounded to 8 bits, and measured as section III says. Noise in time is new in every frame;
noise in space is one fixed pattern, and its curve is the mean over many patterns.

Every curve has an exact expectation. Pixels are independent, with mean m(p) and SD s(p) after
rounding, both known sums; so noise in time is the mean over pixels of the SD of 100 samples, and
the square of the spatial noise has the mean (tr(P S) + |P m|^2) / (n - 1), P the projection that
the column fits leave.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from analysis.bias.rounding import Floats, rounded
from analysis.estimators.parts.panel_noise import measure_panel, parabola_basis
from foundation.panel import Panel
from sensor.camera import Camera
from sensor.colours import Colours
from sensor.effect import Effect
from sensor.effects.fpn import Fpn
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Shot
from sensor.simulation import pixels_of, simulate

Kind = Literal["temporal", "spatial"]

ADDED_DN: Floats = np.concatenate(
    [np.arange(0, 1.0, 0.05), np.arange(1.0, 2.0, 0.1), np.arange(2.0, 5.01, 0.5)]
)
"""Added noise; the paper's range, 0 to 5, finer where the curves turn."""

PEDESTAL_DN = 64.0
"""Level of the dark frames: a whole code, far enough above 0 that nothing is clipped. The paper
does not give its own; clipped at 0, its curves could not peak above zero."""

FRAMES = 100
SIZE_PX = 50
PATTERNS = 24
"""Fixed patterns behind each point of a spatial curve: a standard error of 0.3 % of its noise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorCurve:
    """A curve of Fig. 2 or 3: measured less added noise, its standard error, its expectation."""

    kind: Kind
    gradient: bool
    added_dn: Floats
    error_dn: Floats
    se_dn: Floats
    expected_dn: Floats

    def to_json(self) -> dict[str, Any]:
        """The curve as plain data."""
        arrays = {k: getattr(self, k).tolist() for k in ("added_dn", "error_dn", "se_dn")}
        return {
            "kind": self.kind,
            "gradient": self.gradient,
            "expected_dn": self.expected_dn.tolist(),
        } | arrays


def level_of(rate_e_per_s: Floats, panel: Panel, mean_dn: float) -> Floats:
    """Light of one channel on a panel, in DN, scaled to a mean: only its shape is the lamp's."""
    light = np.asarray(rate_e_per_s[panel.window], dtype=np.float64)
    return np.asarray(light * (mean_dn / light.mean()))


def error_curve(
    kind: Kind,
    level_dn: Floats,
    *,
    gradient: bool,
    added_dn: Floats = ADDED_DN,
    patterns: int = PATTERNS,
    seed: int = 0,
) -> ErrorCurve:
    """A curve from frames of a panel of these levels (h, w) in DN."""
    found = np.array([_measured(kind, level_dn, float(a), patterns, seed) for a in added_dn])
    expected = np.array([expectation(kind, level_dn, float(a)) for a in added_dn])
    return ErrorCurve(
        kind=kind,
        gradient=gradient,
        added_dn=added_dn,
        error_dn=found[:, 0] - added_dn,
        se_dn=found[:, 1],
        expected_dn=expected - added_dn,
    )


def expectation(kind: Kind, level_dn: Floats, added_dn: float, frames: int = FRAMES) -> float:
    """What the measure should find of added noise, in DN; see the top of this file."""
    y = rounded(level_dn, added_dn)
    if kind == "temporal":
        return float(y.sample_sd_dn(frames).mean())
    mean, sd = y.mean_dn, y.sd_dn
    basis = parabola_basis(len(mean))
    share = 1 - np.sum(basis**2, axis=1)  # of a pixel's own variance that the fit leaves
    left = mean - basis @ (basis.T @ mean)
    return math.sqrt(float(share @ np.sum(sd**2, axis=1) + np.sum(left**2)) / (mean.size - 1))


def _measured(
    kind: Kind, level_dn: Floats, added_dn: float, patterns: int, seed: int
) -> tuple[float, float]:
    """Measured noise and its standard error."""
    noise: Effect = ReadNoise(reset_e=0.0, thermal_e=0.0, other_e=added_dn)
    if kind == "spatial":
        noise = Fpn(sigma_e=added_dn)
    height, width = level_dn.shape
    camera = Camera(
        name="one electron per DN",
        width=width,
        height=height,
        pixels="mono8",
        cfa="GGGG",
        gain_dn_per_e=Colours.of(1.0),
        effects=(noise, Quantization()),
    )
    rates = {"level": np.repeat(level_dn[..., None], 3, axis=2).astype(np.float32)}
    shot = Shot(label=f"added-{added_dn:.2f}", light=("level",), exposure_s=1.0, frames=FRAMES)
    if kind == "temporal":
        stack = pixels_of(camera, simulate(camera, shot, rates, seed=seed))
        panel = measure_panel(stack, 255)
        return panel.temporal_dn, panel.temporal_se_dn
    found = []
    for body in range(patterns):
        own = camera.with_body(seed * patterns + body)
        stack = pixels_of(own, simulate(own, shot, rates, seed=seed, frames=range(2)))
        found.append(measure_panel(stack, 255).spatial_dn)
    return float(np.mean(found)), float(np.std(found, ddof=1) / math.sqrt(len(found)))


def pedestal() -> Floats:
    """The even level of a dark panel in DN, (50, 50)."""
    return np.full((SIZE_PX, SIZE_PX), PEDESTAL_DN)
