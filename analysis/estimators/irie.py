"""The technique of Irie et al. as printed: noise parameters of equations (10) to (16).

From dark frames: FPN from noise in space, read and dark-current shot noise from noise in time.
From lit frames: photon shot noise from noise in time, PRNU from noise in space. From every
measured noise first N_Q is taken off, by the curve of Fig. 2 for darks and of Fig. 3 for lit
panels; then it is divided by N_D; then the noises already known are taken off, SD from SD. Each
step is the paper's, its biases included.

Source: Irie, McKinnon, Unsworth, Woodhead, A Technique for Evaluation of CCD Video-Camera Noise.
"""

from __future__ import annotations

import numpy as np

from analysis.estimators.parts.cautions import (
    NO_DARKS,
    NO_LIGHT,
    ONE_EXPOSURE,
    cautions_of,
    clipped,
    clipped_reason,
    saturated,
)
from analysis.estimators.parts.hot_pixels import count_hot_pixels
from analysis.estimators.parts.least_squares import fit
from analysis.estimators.parts.observations import observe, pattern_covariance
from analysis.estimators.parts.panel_noise import Floats
from analysis.estimators.parts.reading import N_D, Reading, point, read_off
from analysis.filled_in import filled_in
from analysis.parameters import UNITS, CannotTell, Estimate, Finding, NoiseParameters, Point
from sensor.frames import Capture

LEAST_SPAN_DN = 1.0
"""Means of lit panels that span less than this do not carry a curve."""

ONE_LEVEL = "the lit panels have one level: add shots of other levels, or panels"
NO_READ = "needs 'read', which these frames cannot tell"
NO_FPN = "needs 'fpn', which these frames cannot tell"
TOO_QUIET = "the dark frames do not change: their noise is below what rounding lets through"
TOO_EVEN = "the dark frames are even: their pattern is below what rounding lets through"


def irie(capture: Capture) -> NoiseParameters:
    """Measure a capture as the paper measured its camera.

    Raises:
        TooFewFrames: where a shot has a single frame.
        CaptureError: where a panel is too small.
    """
    filled = filled_in(capture.frames)
    readings = [read_off(seen, demosaiced=filled) for seen in observe(capture)]
    channels: dict[str, dict[str, Finding]] = {}
    dark_means: dict[str, dict[str, float | None]] = {}
    points: list[Point] = []
    for channel in capture.channels:
        own = [r for r in readings if r.seen.channel == channel]
        darks = [r for r in own if r.seen.shot.dark]
        usable = [r for r in darks if not clipped(r.seen)]
        lit = [r for r in own if not (r.seen.shot.dark or saturated(r.seen) or clipped(r.seen))]
        no_dark = clipped_reason([r.seen for r in darks]) if darks else NO_DARKS
        in_time, shot_dn = _in_time(usable, lit, no_dark)
        in_space, prnu_dn = _in_space(usable, lit, no_dark)
        channels[channel] = in_time | in_space
        dark_means[channel] = _means(usable)
        points += [
            point(
                r,
                {
                    name: float(values[lit.index(r)])
                    for name, values in (("shot_dn", shot_dn), ("prnu_dn", prnu_dn))
                    if r in lit and values is not None
                },
            )
            for r in own
        ]
    return NoiseParameters(
        method="irie",
        channels=channels,
        points=tuple(points),
        warnings=cautions_of(capture, tuple(r.seen for r in readings), filled_in=filled),
        extra={
            "hot_pixels": {f.shot.label: count_hot_pixels(f) for f in capture.darks},
            "demosaic_factors": {k: dict(v) for k, v in N_D.items()} if filled else None,
            "dark_means": dark_means,
        },
    )


def _in_time(
    darks: list[Reading], lit: list[Reading], no_dark: str
) -> tuple[dict[str, Finding], Floats | None]:
    """Read noise, dark-current shot noise, and the photon shot noise curve of equation (14).

    Returns the findings, and SN_ph of every lit reading (Fig. 4).
    """
    curve_names = ("shot_coefficient", "shot_offset")
    if not darks:
        return _cannot(("read", "dark_shot"), no_dark) | _cannot(curve_names, NO_READ), None
    dark = np.array([r.temporal.noise_dn for r in darks])
    if not dark.any():
        return _cannot(("read", "dark_shot"), TOO_QUIET) | _cannot(curve_names, NO_READ), None
    dark_cov = np.diag([r.temporal.se_dn**2 for r in darks])
    exposures = {r.seen.shot.exposure_s for r in darks}
    terms = min(2, len(exposures))
    line = fit(_by_exposure(darks, terms), dark, dark_cov)
    cov = line.covariance(line.misfit * dark_cov)
    found: dict[str, Finding] = {"read": _estimate("read", line.parameters[0], cov[0, 0])}
    if terms == 2:
        longest = max(exposures)
        found["dark_shot"] = _estimate(
            "dark_shot", line.parameters[1] * longest, cov[1, 1] * longest**2
        )
    else:
        found["dark_shot"] = CannotTell(reason=ONE_EXPOSURE)
    if not lit:
        return found | _cannot(curve_names, NO_LIGHT), None

    in_the_dark = _by_exposure(lit, terms)
    shot = np.array([r.temporal.noise_dn for r in lit]) - in_the_dark @ line.parameters
    if _one_level(lit):
        return found | _cannot(curve_names, ONE_LEVEL), shot
    shot_cov = np.diag([r.temporal.se_dn**2 for r in lit])
    mean = np.array([r.seen.noise.mean_dn for r in lit])
    root = fit(np.stack([np.sqrt(mean), np.ones_like(mean)], axis=1), shot, shot_cov)
    whole = root.covariance(root.misfit * shot_cov + in_the_dark @ cov @ in_the_dark.T)
    for k, name in enumerate(curve_names):
        found[name] = _estimate(name, root.parameters[k], whole[k, k])
    return found, shot


def _in_space(
    darks: list[Reading], lit: list[Reading], no_dark: str
) -> tuple[dict[str, Finding], Floats | None]:
    """FPN of equation (10), and the PRNU line of equation (16).

    Returns the findings, and PRNU x I of every lit reading (Fig. 5).
    """
    line_names = ("prnu_slope", "prnu_offset")
    if not darks:
        return _cannot(("fpn",), no_dark) | _cannot(line_names, NO_FPN), None
    every = darks + lit
    cov = pattern_covariance(
        [r.seen for r in every], np.array([r.spatial.se_dn for r in every], dtype=np.float64)
    )
    noise = np.array([r.spatial.noise_dn for r in every])
    d = len(darks)
    if not noise[:d].any():
        return _cannot(("fpn",), TOO_EVEN) | _cannot(line_names, NO_FPN), None
    level = fit(np.ones((d, 1)), noise[:d], cov[:d, :d])
    fpn, fpn_cov = level.parameters[0], level.misfit * level.covariance(cov[:d, :d])
    found: dict[str, Finding] = {"fpn": _estimate("fpn", fpn, fpn_cov[0, 0])}
    if not lit:
        return found | _cannot(line_names, NO_LIGHT), None

    prnu = noise[d:] - fpn
    if _one_level(lit):
        return found | _cannot(line_names, ONE_LEVEL), prnu
    mean = np.array([r.seen.noise.mean_dn for r in lit])
    line = fit(np.stack([mean, np.ones_like(mean)], axis=1), prnu, cov[d:, d:])
    less_fpn = np.hstack([-np.ones((len(lit), 1)) @ level.operator, np.eye(len(lit))])
    whole = line.misfit * line.covariance(less_fpn @ cov @ less_fpn.T)
    for k, name in enumerate(line_names):
        found[name] = _estimate(name, line.parameters[k], whole[k, k])
    return found, prnu


def _by_exposure(readings: list[Reading], terms: int) -> Floats:
    """Design of noise against exposure: a constant, and a slope where `terms` is 2."""
    exposure = np.array([r.seen.shot.exposure_s for r in readings])
    return np.stack([np.ones_like(exposure), exposure], axis=1)[:, :terms]


def _one_level(lit: list[Reading]) -> bool:
    means = [r.seen.noise.mean_dn for r in lit]
    return max(means) - min(means) < LEAST_SPAN_DN


def _cannot(names: tuple[str, ...], reason: str) -> dict[str, Finding]:
    return {name: CannotTell(reason=reason) for name in names}


def _estimate(name: str, value: float, variance: float) -> Estimate:
    return Estimate(value=float(value), se=float(np.sqrt(max(variance, 0.0))), unit=UNITS[name])


def _means(darks: list[Reading]) -> dict[str, float | None]:
    """Dark figures as plain means, in the text's order and in that of equations (10) and (12).

    The text subtracts N_Q and divides by N_D; the equations print sigma - N_Q / N_D.
    """

    def mean(values: list[float]) -> float | None:
        return float(np.mean(values)) if values else None

    return {
        "fpn": mean([r.spatial.noise_dn for r in darks]),
        "fpn_printed": mean([r.spatial.printed_dn for r in darks]),
        "read": mean([r.temporal.noise_dn for r in darks]),
        "read_printed": mean([r.temporal.printed_dn for r in darks]),
    }
