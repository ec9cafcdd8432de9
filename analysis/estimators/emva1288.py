"""EMVA 1288, release 4 linear: noise from variances, gain from photon transfer.

Noise in time from differences of two frames, gain as the slope of its variance against the mean,
read noise from the dark variance less 1/12 of a step, DSNU and PRNU from high-passed mean images
less the noise in time that averaging leaves. Defined for raw frames under even light: on
demosaiced ones, and between panels, it is a rival on foreign ground.

Source: EMVA Standard 1288, Release 4.0 Linear (2021), https://www.emva.org.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.parts.cautions import (
    NO_DARKS,
    NO_LIGHT,
    ONE_EXPOSURE,
    cautions_of,
    clipped,
    clipped_reason,
    saturated,
)
from analysis.estimators.parts.high_pass import spatial_variance
from analysis.estimators.parts.least_squares import fit
from analysis.estimators.parts.map_error import se_of_mean
from analysis.estimators.parts.observations import Observation, observe
from analysis.estimators.parts.panel_noise import FEW_FRAMES, Floats
from analysis.filled_in import filled_in
from analysis.parameters import UNITS, CannotTell, Estimate, Finding, NoiseParameters, Point
from sensor.frames import Capture, Frames, Panel

QUANTIZATION_DN2 = 1 / 12
"""Variance of rounding to whole DN."""

LEAST_DARK_VARIANCE_DN2 = 0.24
"""Below this dark variance rounding dominates, and the standard gives an upper limit only."""

REGRESSION = 0.7
"""The photon transfer line is fitted up to this share of saturation."""

HALF = 0.5
"""PRNU is read at the level nearest to this share of saturation."""

FAINT = 2.0
"""Standard errors that a variance must stand above 0 for its root to be told."""

RAW_ONLY = (
    "EMVA 1288 is defined on raw frames: these are demosaiced, so gain, read noise, DSNU and PRNU"
    " carry the demosaic's attenuation"
)


UNDEFINED = {
    "fpn": "EMVA 1288 has DSNU in its place, of high-passed frames: see dsnu",
    "shot_coefficient": "EMVA 1288 has the gain in its place, which is its square: see gain",
    "shot_offset": "EMVA 1288 has no such term: its line of variance goes through the dark",
    "prnu_slope": "EMVA 1288 has PRNU in its place, at half saturation: see prnu",
    "prnu_offset": "EMVA 1288 has no such term: PRNU is told at one level, less the dark",
}
"""Parameters of the paper that the standard does not define."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Level:
    """One panel of one shot in one channel: its mean and both variances, in DN and DN^2."""

    seen: Observation
    mean_dn: float
    temporal_dn2: float
    temporal_se: float
    spatial_dn2: float
    spatial_se: float


def emva1288(capture: Capture) -> NoiseParameters:
    """Measure a capture by the definitions of EMVA 1288.

    Raises:
        TooFewFrames: where a shot has a single frame.
        CaptureError: where a panel is too small.
    """
    observations = observe(capture)
    stacks = {frames.shot.label: frames for frames in capture.frames}
    areas = {panel.name: panel for panel in capture.areas}
    levels = [_level(seen, stacks[seen.shot.label], areas[seen.panel]) for seen in observations]
    top_dn = capture.frames[0].top_dn
    filled = filled_in(capture.frames)
    warnings = cautions_of(capture, observations, filled_in=filled)
    if filled:
        warnings += (RAW_ONLY,)
    return NoiseParameters(
        method="emva1288",
        channels={
            channel: _channel([v for v in levels if v.seen.channel == channel], top_dn)
            for channel in capture.channels
        },
        points=tuple(_point(level) for level in levels),
        warnings=warnings,
    )


def _channel(levels: list[Level], top_dn: int) -> dict[str, Finding]:
    darks = [v for v in levels if v.seen.shot.dark]
    usable = [v for v in darks if not clipped(v.seen)]
    lit = [v for v in levels if not (v.seen.shot.dark or saturated(v.seen) or clipped(v.seen))]
    if not usable:
        reason = clipped_reason([v.seen for v in darks]) if darks else NO_DARKS
        keys = ("read", "dark_shot", "gain", "dsnu", "prnu")
        return {key: CannotTell(reason=reason) for key in keys}
    found = _in_the_dark(usable)
    if not lit:
        return found | {key: CannotTell(reason=NO_LIGHT) for key in ("gain", "prnu")}
    return found | {"gain": _gain(lit, usable, top_dn), "prnu": _prnu(lit, usable, top_dn)}


def _in_the_dark(darks: list[Level]) -> dict[str, Finding]:
    """Read noise, dark-current shot noise and DSNU: variance in time is a line in exposure."""
    variance = np.array([v.temporal_dn2 for v in darks])
    errors = np.diag([v.temporal_se**2 for v in darks])
    exposure = np.array([v.seen.shot.exposure_s for v in darks])
    terms = min(2, len(set(exposure)))
    line = fit(np.stack([np.ones_like(exposure), exposure], axis=1)[:, :terms], variance, errors)
    cov = line.covariance(line.misfit * errors)
    found: dict[str, Finding] = {}
    if line.parameters[0] < LEAST_DARK_VARIANCE_DN2:
        found["read"] = CannotTell(
            reason=f"the dark variance is {line.parameters[0]:.3f} DN^2: below 0.24 rounding"
            " dominates; raise the camera's gain or its bits"
        )
    else:
        found["read"] = _root("read", line.parameters[0] - QUANTIZATION_DN2, cov[0, 0] ** 0.5)
    if terms == 2:
        longest = exposure.max()
        found["dark_shot"] = _root(
            "dark_shot", line.parameters[1] * longest, cov[1, 1] ** 0.5 * longest
        )
    else:
        found["dark_shot"] = CannotTell(reason=ONE_EXPOSURE)
    by_panel: dict[str, list[Level]] = {}
    for v in darks:
        by_panel.setdefault(v.seen.panel, []).append(v)
    pattern = [np.mean([v.spatial_dn2 for v in own]) for own in by_panel.values()]
    # Shots of one panel see the same pattern: averaging them does not make its error smaller.
    error = [np.mean([v.spatial_se for v in own]) for own in by_panel.values()]
    found["dsnu"] = _root(
        "dsnu", float(np.mean(pattern)), float(np.linalg.norm(error)) / len(pattern)
    )
    return found


def _gain(lit: list[Level], darks: list[Level], top_dn: int) -> Finding:
    """Slope through 0 of variance against mean, both less their darks, up to 70 % saturation."""
    pairs = [(v, _dark_of(v, darks)) for v in lit]
    pairs = [
        (v, d) for v, d in pairs if 0 < v.mean_dn - d.mean_dn <= REGRESSION * (top_dn - d.mean_dn)
    ]
    if not pairs:
        return CannotTell(reason="no lit panel between dark and 70 % of saturation: add one")
    signal = np.array([v.mean_dn - d.mean_dn for v, d in pairs])
    variance = np.array([v.temporal_dn2 - d.temporal_dn2 for v, d in pairs])
    shared = np.array([[d is e for _, e in pairs] for _, d in pairs])
    dark_se = np.array([d.temporal_se for _, d in pairs])
    errors = np.diag([v.temporal_se**2 for v, _ in pairs]) + shared * np.outer(dark_se, dark_se)
    line = fit(signal[:, None], variance, errors)
    se = line.misfit * line.covariance(errors)[0, 0]
    return Estimate(value=float(line.parameters[0]), se=float(se**0.5), unit=UNITS["gain"])


def _prnu(lit: list[Level], darks: list[Level], top_dn: int) -> Finding:
    """Spatial SD less that of the dark, over the mean less the dark's, nearest half saturation."""
    level = min(lit, key=lambda v: abs(v.mean_dn - HALF * top_dn))
    dark = _dark_of(level, darks)
    signal = level.mean_dn - dark.mean_dn
    if signal <= 0:
        return CannotTell(reason="the lit panels are no brighter than the darks: add light")
    return _root(
        "prnu",
        (level.spatial_dn2 - dark.spatial_dn2) / signal**2,
        float(np.hypot(level.spatial_se, dark.spatial_se)) / signal**2,
    )


def _dark_of(level: Level, darks: list[Level]) -> Level:
    """A lit panel in the dark, at the exposure nearest to its own; any panel if it has no dark."""
    same = [d for d in darks if d.seen.panel == level.seen.panel] or darks
    return min(same, key=lambda d: abs(d.seen.shot.exposure_s - level.seen.shot.exposure_s))


def _root(key: str, variance: float, se: float) -> Finding:
    """An SD from a variance; none where the variance may be 0."""
    if variance <= FAINT * se:
        limit = max(variance + FAINT * se, 0.0) ** 0.5
        return CannotTell(
            reason=f"not seen: these frames only say that it is below {limit:.3g} {UNITS[key]}"
        )
    sd = variance**0.5
    return Estimate(value=float(sd), se=float(se / (2 * sd)), unit=UNITS[key])


def _level(seen: Observation, frames: Frames, panel: Panel) -> Level:
    """Both variances of a panel; lattices of one colour are pooled pixel by pixel."""
    parts = [_variances(lattice) for lattice in frames.lattices(panel, seen.channel)]
    value = np.mean(parts, axis=0)
    error = np.linalg.norm(parts, axis=0) / len(parts)
    return Level(
        seen=seen,
        mean_dn=seen.noise.mean_dn,
        temporal_dn2=float(value[0]),
        temporal_se=float(error[1]),
        spatial_dn2=float(value[2]),
        spatial_se=float(error[3]),
    )


def _variances(stack: NDArray[Any]) -> tuple[float, float, float, float]:
    """Variance in time and its error, variance in space and its error.

    In time: half the mean squared difference of two frames, less half the squared difference of
    their means; averaged over the pairs of the stack. In space: of the mean image, less what
    averaging N frames leaves of the noise in time.
    """
    n = len(stack)
    total = np.zeros(stack.shape[1:])
    spread = np.zeros(stack.shape[1:])
    by_pair: list[float] = []
    for k in range(0, n, 2):
        pair = stack[k : k + 2].astype(np.float64)
        total += pair.sum(axis=0)
        if len(pair) == 2:
            difference = pair[1] - pair[0]
            squares = 0.5 * np.square(difference - difference.mean())
            spread += squares
            by_pair.append(float(squares.mean()))
    temporal = float(np.mean(by_pair))
    pairs = len(by_pair)
    if pairs < FEW_FRAMES:
        temporal_se = se_of_mean(spread / pairs)
    else:
        temporal_se = float(np.std(by_pair, ddof=1) / pairs**0.5)
    image: Floats = total / n
    measured, measured_se = spatial_variance(image)
    return temporal, temporal_se, measured - temporal / n, measured_se


def _point(level: Level) -> Point:
    seen = level.seen
    return Point(
        shot=seen.shot.label,
        panel=seen.panel,
        channel=seen.channel,
        mean_dn=level.mean_dn,
        temporal_dn=seen.noise.temporal_dn,
        spatial_dn=seen.noise.spatial_dn,
        rows_dn=seen.noise.rows_dn,
        columns_dn=seen.noise.columns_dn,
        more={
            "exposure_s": seen.shot.exposure_s,
            "temporal_variance_dn2": level.temporal_dn2,
            "temporal_variance_se_dn2": level.temporal_se,
            "spatial_variance_dn2": level.spatial_dn2,
            "spatial_variance_se_dn2": level.spatial_se,
        },
    )
