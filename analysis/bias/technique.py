"""The printed technique from panel noises to parameters, each of its steps open to exchange.

With nothing exchanged it gives what `analysis.estimators.irie` gives, whose code it shares below
the fits. Exchanging one step alone shows what that step costs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from analysis.bias.demosaic import detrended_variance, site_factors
from analysis.bias.prediction import Seen
from analysis.bias.rounding import ROUNDING_DN2, Floats, sample_sd_factor
from analysis.estimators.parts.quantization import Kind, curve
from analysis.estimators.parts.reading import N_D


@dataclass(frozen=True, kw_only=True)
class Technique:
    """How noise is corrected; the defaults are the paper's.

    Attributes:
        variances: known noises are taken off as variances, and curves fitted to variances.
        less_residual: a stack's share 1/N of the noise in time is taken off the spatial figure.
        exact_rounding: variance 1/12 is taken off instead of the curves of N_Q, whose fixed
            patterns are rounded without the noise in time that stirs them.
        step_variance: what `exact_rounding` takes off; 0 for frames that were never rounded.
        exact_sites: N_D and rounding in time site by site of the demosaic, whose SDs differ,
            instead of Table V's mean.
        exact_freedom: N_D in space by the degrees of freedom that column fits leave of correlated
            noise, instead of Table V.
        above_black: noise against mean less black level instead of against the mean.
    """

    variances: bool = False
    less_residual: bool = False
    exact_rounding: bool = False
    step_variance: float = ROUNDING_DN2
    exact_sites: bool = False
    exact_freedom: bool = False
    above_black: bool = False


PRINTED = Technique()
REPAIRED = Technique(
    variances=True,
    less_residual=True,
    exact_rounding=True,
    exact_sites=True,
    exact_freedom=True,
    above_black=True,
)
"""Every step exchanged."""


def parameters(
    seen: Sequence[Seen],
    channel: str,
    *,
    demosaiced: bool,
    black_dn: float = 0.0,
    technique: Technique = PRINTED,
) -> dict[str, float]:
    """Noise parameters of one channel; darks at several exposures, lit panels of several levels."""
    darks, lit = [s for s in seen if s.dark], [s for s in seen if not s.dark]
    time = np.array([corrected(s, "temporal", channel, demosaiced, technique) for s in seen])
    space = np.array([corrected(s, "spatial", channel, demosaiced, technique) for s in seen])
    if technique.less_residual:
        frames = np.array([s.frames for s in seen])
        space = np.sqrt(np.maximum(space**2 - time**2 / frames, 0.0))
    is_dark = np.array([s.dark for s in seen])
    power = 2 if technique.variances else 1
    exposure = np.array([s.exposure_s for s in darks])
    terms = min(2, len(set(exposure.tolist())))
    line = _fit(
        np.stack([np.ones_like(exposure), exposure], axis=1)[:, :terms], time[is_dark] ** power
    )
    longest = float(exposure.max())
    grown = float(line[1]) * longest if terms == 2 else 0.0
    fpn = float(np.mean(space[is_dark] ** power))
    found = {"read": _root(float(line[0]), power), "fpn": _root(fpn, power)}
    if terms == 2:
        found["dark_shot"] = _root(grown, power)
    if not lit:
        return found
    mean = np.array([s.mean_dn for s in lit]) - (black_dn if technique.above_black else 0.0)
    lit_exposure = np.array([s.exposure_s for s in lit])
    in_the_dark = np.stack([np.ones_like(lit_exposure), lit_exposure], axis=1)[:, :terms] @ line
    shot = time[~is_dark] ** power - in_the_dark
    prnu = space[~is_dark] ** power - fpn
    across = np.maximum(mean, 0.0) ** (0.5 * power)
    k = _fit(np.stack([across, np.ones_like(mean)], axis=1), shot)
    p = _fit(np.stack([mean**power, np.ones_like(mean)], axis=1), prnu)
    found |= {
        "shot_coefficient": _root(float(k[0]), power),
        "shot_offset": _root(float(k[1]), power),
    }
    found |= {"prnu_slope": _root(float(p[0]), power), "prnu_offset": _root(float(p[1]), power)}
    return found


def corrected(s: Seen, kind: Kind, channel: str, demosaiced: bool, technique: Technique) -> float:
    """A noise before rounding and demosaic, N_Q and N_D taken off."""
    free = detrended_variance("G", s.rows, s.rows, demosaiced=False)
    if kind == "temporal" and demosaiced and technique.exact_sites:
        return _site_by_site(s, site_factors(channel, demosaiced=True), technique)
    measured = s.temporal_dn if kind == "temporal" else s.spatial_dn
    if technique.exact_rounding:
        # White rounding noise lies in every frame anew: the mean image holds 1/N of it.
        step = technique.step_variance * (1.0 if kind == "temporal" else free / s.frames)
        fit_taken = kind == "temporal"
        before = math.sqrt(max(measured**2 - step, 0.0))
        before /= sample_sd_factor(s.frames) if kind == "temporal" else 1.0
    else:
        fit_taken = True  # the curve of N_Q is drawn against noise before the fit
        at = curve(kind, gradient=not s.dark, rows=s.rows, frames=s.frames)
        before = at.noise_before(measured)[0]
    if kind == "temporal":
        return before / (N_D[kind][channel] if demosaiced else 1.0)
    whole = math.sqrt(detrended_variance(channel, s.rows, s.rows, demosaiced=demosaiced))
    n_d = whole / math.sqrt(free)
    if demosaiced and not technique.exact_freedom:
        n_d = N_D[kind][channel]
    return before / (n_d if fit_taken else n_d * math.sqrt(free))


def _site_by_site(s: Seen, factors: Floats, technique: Technique) -> float:
    """The noise of a photosite whose rounded noises, averaged over the sites, are the measured."""
    if technique.exact_rounding:
        low = math.sqrt(technique.step_variance)
        factor = sample_sd_factor(s.frames)

        def short(sd: float) -> float:
            each = np.sqrt((factors * sd) ** 2 + technique.step_variance)
            return factor * float(each.mean()) - s.temporal_dn

        if s.temporal_dn <= factor * low:
            return 0.0
        return float(brentq(short, 0.0, 10 * s.temporal_dn + 1))
    at = curve("temporal", gradient=not s.dark, rows=s.rows, frames=s.frames)
    added = np.append(at.added_dn, 100.0)
    measured = np.append(at.measured_dn, 100.0 * at.measured_dn[-1] / at.added_dn[-1])
    sd = np.linspace(0, 2 * float(added[-2]), 801)
    over_sites = np.maximum.accumulate(
        np.interp(np.outer(sd, factors), added, measured).mean(axis=1)
    )
    return float(np.interp(s.temporal_dn, over_sites, sd))


def _fit(design: Floats, points: Floats) -> Floats:
    return np.asarray(np.linalg.pinv(design) @ points, dtype=np.float64)


def _root(value: float, power: int) -> float:
    """A figure of a fit to variances, as an SD; below 0 the SD of its size, negative."""
    return math.copysign(abs(value) ** (1 / power), value)
