"""The noise that a camera of equation (1) must show in a panel, in closed form.

Noise in time of a photosite has the variance s^2 = read^2 + dark^2 + g (mu - b), in space
f^2 = fpn^2 + p^2 (mu - b)^2. At a site of the demosaic both shrink by its factor a; then the sum
is rounded, exactly (`rounding`):

    temporal   mean over sites (and over the lamp's gradient) of the mean SD of N samples
    spatial    K var(E[y | pattern])  +  K' E[var(y)] / N

K and K' are what column fits leave of the pattern and of the rounded noise (`demosaic`): rounding
noise is white, the rest is correlated by the demosaic. Under a gradient the place between two
codes is spread evenly; in the dark it is that of the black level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from analysis.bias.demosaic import detrended_variance, site_factors
from analysis.bias.rounding import Floats, rounded

PHASES: Floats = (np.arange(16) + 0.5) / 16 - 0.5
"""Places between two codes that stand for an even spread."""

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(41)
"""Gauss-Hermite points over a Gaussian pattern."""


@dataclass(frozen=True, kw_only=True)
class Make:
    """One channel of a camera, as equation (1) needs it; DN, and DN/e- for the gain."""

    channel: str
    gain: float
    read: float
    fpn: float
    prnu: float
    black: float
    dark_e_per_s: float = 0.0
    demosaiced: bool = True
    top: int = 255


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What section III measures in a panel of one channel, in DN, measured or predicted."""

    shot: str
    dark: bool
    exposure_s: float
    frames: int
    rows: int
    mean_dn: float
    temporal_dn: float
    spatial_dn: float


def predict(
    make: Make,
    *,
    shot: str,
    light_dn: float,
    exposure_s: float,
    frames: int,
    size_px: int = 50,
    gradient: bool = True,
) -> Seen:
    """A panel whose light is `light_dn` above the black level.

    Args:
        make: the channel.
        shot: its label.
        light_dn: mean signal of the light.
        exposure_s: integration time.
        frames: frames in the stack.
        size_px: side of the panel.
        gradient: whether the lamp's gradient sweeps codes; without, all pixels have one level.
    """
    level = make.black + light_dn
    in_time = math.sqrt(
        make.read**2
        + make.gain**2 * make.dark_e_per_s * exposure_s
        + make.gain * max(light_dn, 0.0)
    )
    in_space = math.hypot(make.fpn, make.prnu * light_dn)
    sites = site_factors(make.channel, demosaiced=make.demosaiced)
    phases = PHASES if light_dn > 0 and gradient else np.zeros(1)
    # Axes: site, phase, place in the pattern.
    pattern = sites[:, None, None] * in_space * NODES
    y = rounded(level + phases[None, :, None] + pattern, sites[:, None, None] * in_time, make.top)
    weight = WEIGHTS / WEIGHTS.sum()
    temporal = float((y.sample_sd_dn(frames) @ weight).mean())

    centred = y.mean_dn - phases[None, :, None] - level
    first = centred @ weight
    of_pattern = (centred**2 @ weight) - first**2
    steps = first - first.mean()  # codes swept by the gradient, less the gradient
    white = float(np.mean(steps**2)) + float(np.mean((y.sd_dn**2) @ weight)) / frames
    interpolated = float(np.mean(of_pattern)) + in_time**2 * float(np.mean(sites**2)) / frames
    rounding = max(white - in_time**2 * float(np.mean(sites**2)) / frames, 0.0)
    kept = _kept(make, size_px)
    kept_white = detrended_variance("G", size_px, size_px, demosaiced=False)
    return Seen(
        shot=shot,
        dark=light_dn <= 0,
        exposure_s=exposure_s,
        frames=frames,
        rows=size_px,
        mean_dn=float(np.mean(y.mean_dn @ weight)),
        temporal_dn=temporal,
        spatial_dn=math.sqrt(kept * interpolated + kept_white * rounding),
    )


def _kept(make: Make, size_px: int) -> float:
    """What the column fits leave of interpolated noise, relative to its mean square."""
    whole = detrended_variance(make.channel, size_px, size_px, demosaiced=make.demosaiced)
    return whole / float(np.mean(site_factors(make.channel, demosaiced=make.demosaiced) ** 2))
