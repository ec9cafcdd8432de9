"""Equations (2) to (7) and Table V: what rounding adds and what a bilinear demosaic leaves.

Noise of growing SD is put on even frames, once without and once with the demosaic, and measured as
section III says; the ratio of the two slopes of measured against added noise is the attenuation.
The spatial one has two readings. Against the noise that was added, column fits count as if the
demosaic had done it; against equally detrended noise they cancel, but for what the fits take more
of noise that the demosaic has correlated. Only the second gives what Table V prints.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.bias.demosaic import detrended_variance, site_factors
from analysis.bias.rounding import Floats, rounded
from analysis.estimators.parts.panel_noise import measure_panel
from analysis.reproduce.paper import Line, compare
from foundation.panel import Panel
from sensor.camera import Camera
from sensor.colours import CHANNELS, Colours
from sensor.effect import Effect
from sensor.effects.demosaic import Demosaic
from sensor.effects.fpn import Fpn
from sensor.effects.quantization import Quantization
from sensor.effects.read_noise import ReadNoise
from sensor.protocol import Shot
from sensor.simulation import pixels_of, simulate

ADDED_DN = (5.0, 10.0, 15.0, 20.0)
"""Far above a step, so that rounding (1/12 of a variance) does not bend the slope, and far enough
below the pedestal of 128 that nothing is clipped. The paper's 0 to 5 needs N_Q taken off first."""

PEDESTAL_DN = 128.0
FRAMES = 100
BODIES = 16
SIZE_PX = 50
MARGIN_PX = 4


def equations() -> tuple[Line, ...]:
    """Equations (3) to (7), in closed form."""
    at_large = rounded(PEDESTAL_DN + np.arange(16) / 16, 5.0)
    added = float(np.sqrt(np.mean(at_large.sd_dn**2) - 25.0))
    lines = [compare("quantization_sd", added, 0.0, expected=1 / math.sqrt(12))]
    lines.append(compare("demosaic_interpolated", math.sqrt(4 / 16), 0.0, channel="G"))
    for channel in CHANNELS:
        mean = float(site_factors(channel, demosaiced=True).mean())
        lines.append(compare("demosaic_sd", mean, 0.0, channel=channel))
    return tuple(lines)


def table_5(seed: int = 0, bodies: int = BODIES) -> tuple[Line, ...]:
    """Table V from frames, spatial noise by both readings; standard errors over camera bodies."""
    found = np.array([_slopes(seed + body) for body in range(bodies)])  # body, kind, with, channel
    ratio = {
        "table_5_temporal": found[:, 0, 1] / found[:, 0, 0],
        "table_5_spatial": found[:, 1, 1] / found[:, 1, 0],
        "table_5_spatial_raw": found[:, 1, 1],
    }
    lines = []
    for key, values in ratio.items():
        for k, channel in enumerate(CHANNELS):
            lines.append(
                compare(
                    key,
                    float(values[:, k].mean()),
                    float(values[:, k].std(ddof=1) / math.sqrt(bodies)),
                    channel=channel,
                    expected=expected_attenuation(key, channel),
                    why="Each column's parabola takes 3 of 50 degrees of freedom (6 % of the"
                    " variance) of noise that was added whole; the paper's figures are against"
                    " noise that went through the same fit.",
                )
            )
    return tuple(lines)


def expected_attenuation(key: str, channel: str) -> float:
    """The attenuation that theory gives, for a key of Table V."""
    if key == "table_5_temporal":
        return float(site_factors(channel, demosaiced=True).mean())
    after = detrended_variance(channel, SIZE_PX, SIZE_PX, demosaiced=True)
    before = detrended_variance(channel, SIZE_PX, SIZE_PX, demosaiced=False)
    return math.sqrt(after if key == "table_5_spatial_raw" else after / before)


def _slopes(body: int) -> Floats:
    """Slope of measured against added noise: [temporal, spatial][without, with demosaic][R G B]."""
    kinds: tuple[type[Effect], ...] = (ReadNoise, Fpn)
    slopes = np.zeros((2, 2, 3))
    added = np.array(ADDED_DN)
    for i, kind in enumerate(kinds):
        for j, demosaiced in enumerate((False, True)):
            noise = np.array(
                [
                    _measured(kind, sd, body * len(ADDED_DN) + k, demosaiced)
                    for k, sd in enumerate(ADDED_DN)
                ]
            )
            slopes[i, j] = added @ noise / (added @ added)
    return slopes


def _measured(kind: type[Effect], added_dn: float, body: int, demosaiced: bool) -> Floats:
    side = SIZE_PX + 2 * MARGIN_PX
    noise = (
        Fpn(sigma_e=added_dn)
        if kind is Fpn
        else ReadNoise(reset_e=0.0, thermal_e=0.0, other_e=added_dn)
    )
    camera = Camera(
        name="one electron per DN",
        width=side,
        height=side,
        pixels="rgb8" if demosaiced else "mono8",
        cfa="RGGB" if demosaiced else "GGGG",
        gain_dn_per_e=Colours.of(1.0),
        black_dn=PEDESTAL_DN,
        effects=(noise, *((Demosaic(),) if demosaiced else ()), Quantization()),
        body_seed=body,
    )
    shot = Shot(label="dark", exposure_s=1.0, frames=FRAMES)
    frames = range(2) if kind is Fpn else range(FRAMES)
    stack = pixels_of(camera, simulate(camera, shot, {}, seed=body, frames=frames))
    window = Panel(name="middle", x=MARGIN_PX, y=MARGIN_PX, w=SIZE_PX, h=SIZE_PX).window
    planes = [stack[:, *window, k] if demosaiced else stack[:, *window] for k in range(3)]
    panels = [measure_panel(plane, 255) for plane in (planes if demosaiced else planes[:1])]
    values = [p.spatial_dn if kind is Fpn else p.temporal_dn for p in panels]
    return np.array(values if demosaiced else values * 3)
