"""Photon transfer as laboratories do it by hand: differences of frames, straight lines.

Noise in time is half the variance of the difference of two frames, which no fixed pattern enters.
Against the mean above black it is a line: its slope is the gain, its intercept the read noise.
Fixed patterns are the variance of the mean image less what averaging leaves of the noise in time;
against the square of the signal that is a line too, of FPN and PRNU. Nothing is done about
rounding, demosaic or shading: a ramp of light counts as PRNU.

Source: Janesick, Photon Transfer, SPIE 2007, chapters 4 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.cautions import CLIPPED, NO_DARKS, NO_LIGHT, SATURATED, no_panels
from analysis.estimators.parts.observations import require_pairs
from analysis.estimators.parts.panel_noise import Floats
from analysis.parameters import UNITS, CannotTell, Estimate, Finding, NoiseParameters
from sensor.frames import Capture, Frames, Panel

KEYS = ("read", "gain", "shot_coefficient", "fpn", "dsnu", "prnu", "prnu_slope")
NEGATIVE = "the line of variance comes out below 0: what was not taken off is larger than it"

UNDEFINED = {
    "dark_shot": "photon transfer takes darks of all exposures together: see read",
    "shot_offset": "photon transfer has no such term: its line of variance starts in the dark",
    "prnu_offset": "photon transfer has no such term: its line of variance starts in the dark",
}
"""Parameters of the paper that photon transfer does not define."""


@dataclass(frozen=True, kw_only=True)
class Place:
    """A panel of a shot in one channel: mean in DN, variances in DN^2 with their errors."""

    dark: bool
    mean: float
    temporal: float
    temporal_se: float
    spatial: float
    spatial_se: float


def photon_transfer(capture: Capture) -> NoiseParameters:
    """Measure a capture by two straight lines.

    Raises:
        TooFewFrames: where a shot has a single frame.
    """
    require_pairs(capture)
    channels = {}
    for channel in capture.channels:
        places = [
            place
            for frames in capture.frames
            for panel in capture.areas
            if (place := _place(frames, panel, channel)) is not None
        ]
        channels[channel] = _channel(places)
    return NoiseParameters(
        method="photon_transfer", channels=channels, warnings=tuple(no_panels(capture))
    )


def _channel(places: list[Place]) -> dict[str, Finding]:
    dark = np.array([p.dark for p in places], dtype=bool)
    if not dark.any() or dark.all():
        reason = NO_DARKS if not dark.any() else NO_LIGHT
        return {key: CannotTell(reason=reason) for key in KEYS}
    mean = np.array([p.mean for p in places])
    signal = np.where(dark, 0.0, mean - mean[dark].mean())
    read, gain = line(
        signal,
        np.array([p.temporal for p in places]),
        np.array([p.temporal_se for p in places]),
    )
    fpn, prnu = line(
        signal**2,
        np.array([p.spatial for p in places]),
        np.array([p.spatial_se for p in places]),
    )
    return {
        "read": _root("read", *read),
        "gain": Estimate(value=gain[0], se=gain[1], unit=UNITS["gain"]),
        "shot_coefficient": _root("shot_coefficient", *gain),
        "fpn": _root("fpn", *fpn),
        "dsnu": _root("dsnu", *fpn),
        "prnu": _root("prnu", *prnu),
        "prnu_slope": _root("prnu_slope", *prnu),
    }


def line(x: Floats, y: Floats, se: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Weighted line: intercept and slope, each with its standard error."""
    design = np.stack([np.ones_like(x), x], axis=1) / se[:, None]
    covariance = np.linalg.pinv(design.T @ design)
    intercept, slope = covariance @ design.T @ (y / se)
    errors = np.sqrt(np.diag(covariance))
    return (float(intercept), float(errors[0])), (float(slope), float(errors[1]))


def _root(key: str, variance: float, se: float) -> Finding:
    if variance <= 0:
        return CannotTell(reason=NEGATIVE)
    sd = variance**0.5
    return Estimate(value=sd, se=se / (2 * sd), unit=UNITS[key])


def _place(frames: Frames, panel: Panel, channel: str) -> Place | None:
    """Both variances of a panel, lattices pooled; None at either end of the range."""
    parts = [_variances(stack, frames.top_dn) for stack in frames.lattices(panel, channel)]
    if any(part is None for part in parts):
        return None
    mean, temporal, spatial, freedom = np.mean([p for p in parts if p is not None], axis=0)
    samples = freedom * len(parts)
    pairs = frames.count // 2
    n = frames.count
    return Place(
        dark=frames.shot.dark,
        mean=float(mean),
        temporal=float(temporal),
        temporal_se=float((temporal + 1e-6) * (2 / (samples * pairs)) ** 0.5),
        spatial=float(spatial - temporal / n),
        spatial_se=float((spatial + 1e-6) * (2 / samples) ** 0.5),
    )


def _variances(stack: NDArray[Any], top_dn: int) -> tuple[float, float, float, float] | None:
    """Mean, variance in time by differences of frames, variance of the mean image, samples."""
    if np.mean(stack == 0) >= CLIPPED or np.mean(stack >= top_dn) > SATURATED:
        return None
    even = stack[: 2 * (len(stack) // 2)].astype(np.float32)
    difference = even[1::2] - even[::2]
    temporal = 0.5 * float(difference.var(axis=(1, 2), ddof=1, dtype=np.float64).mean())
    image = stack.mean(axis=0, dtype=np.float64)
    return float(image.mean()), temporal, float(image.var(ddof=1)), float(image.size)
