"""One lattice of one shot: its level site by site, its noise in time, and how well both are known.

Two ways lead there. Where noise is well above a step and no sample touches an end of the range,
rounding adds 1/12 DN^2 to the variance and nothing to the mean, to a few parts in 10^5, whatever
the distribution: unbiased sample moments tell all. Elsewhere the likelihood of the codes does
(`codes`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.correction.codes import count_codes, fit_codes
from analysis.estimators.correction.shading import basis, highest
from analysis.estimators.correction.spread import (
    LEAST_DN,
    SAFE_DN,
    SPREAD_DN,
    noise_behind,
    sawtooth,
)
from analysis.estimators.parts.panel_noise import Floats

ROUNDING_DN2 = 1 / 12
"""Variance that rounding adds to noise well above a step."""

LOUD_DN = 0.8
"""Noise from which moments are used. The variance of rounded noise s departs from s^2 + 1/12 by up
to (4 s^2 + 1/pi^2) exp(-2 pi^2 s^2): 1.4 parts in 10^5 of s^2 at 0.8, 4 in 1000 at 0.5 DN."""

PRIOR_DEGREE = 2
"""Degree of the smooth level about which the likelihood lets the pattern scatter. Where codes are
counted levels are low and shading is weak; what is left of it widens the pattern a little."""

VAGUE = 0.1
"""Relative error of a variance from which it is not told: noise and pattern are then confounded."""

SINGLE = 0.9
"""Share of sites with a single code from which the rest are too few."""

HIDDEN = 0.5
"""Share at an end of the range from which the median itself is hidden."""

SECTION_FRAMES = 1000
"""Longer stacks are measured section by section and averaged, so that memory does not grow."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cell:
    """One native lattice of one shot.

    Attributes:
        frames: frames in the stack.
        mean_dn: mean level.
        level_dn: level of each site, (n,), with an error of variance `level_variance_dn2` each.
        variance_dn2, variance_se_dn2: temporal variance before rounding, and its standard error.
        frame_chi2: variance of the frames' means over what independent sites allow; 1 in the mean.
        at_zero, at_top: share of samples at either end of the range.
        resolved: share of the fixed pattern that the frames resolve; 1 for moments.
        single: share of sites that gave the same code in every frame.
    """

    frames: int
    mean_dn: float
    level_dn: Floats
    level_variance_dn2: float
    variance_dn2: float
    variance_se_dn2: float
    frame_chi2: float
    at_zero: float
    at_top: float
    resolved: float
    single: float

    @property
    def told(self) -> bool:
        """Whether the codes tell noise and levels."""
        return (
            self.variance_dn2 > LEAST_DN**2
            and self.variance_se_dn2 < VAGUE * self.variance_dn2
            and self.single < SINGLE
        )


def measure_cell(stack: NDArray[Any], top_dn: int, row: Floats, column: Floats) -> Cell:
    """Measure a stack (N, h, w) of a lattice whose sites lie at `row`, `column`."""
    sections = -(-len(stack) // SECTION_FRAMES)
    parts = np.array_split(np.arange(len(stack)), sections)
    cells = [_section(stack[p[0] : p[-1] + 1], top_dn, row, column) for p in parts]
    return cells[0] if sections == 1 else _average(cells)


def _average(cells: list[Cell]) -> Cell:
    """One cell from the sections of a stack, all nearly of one length."""

    def mean(name: str) -> float:
        return float(np.mean([getattr(cell, name) for cell in cells]))

    count = len(cells)
    return Cell(
        frames=sum(cell.frames for cell in cells),
        mean_dn=mean("mean_dn"),
        level_dn=np.mean([cell.level_dn for cell in cells], axis=0),
        level_variance_dn2=mean("level_variance_dn2") / count,
        variance_dn2=mean("variance_dn2"),
        variance_se_dn2=mean("variance_se_dn2") / count**0.5,
        frame_chi2=mean("frame_chi2"),
        at_zero=mean("at_zero"),
        at_top=mean("at_top"),
        resolved=mean("resolved"),
        single=min(cell.single for cell in cells),
    )


def _section(stack: NDArray[Any], top_dn: int, row: Floats, column: Floats) -> Cell:
    n, h, w = stack.shape
    samples = np.ascontiguousarray(stack).reshape(n, h * w)
    low, high = int(samples.min()), int(samples.max())
    mean, variance, frame_mean = _moments(samples)
    moment = float(variance.mean())
    spread = float(frame_mean.var(ddof=1))
    found: dict[str, Any] = {
        "frames": n,
        "frame_chi2": spread * h * w / moment if moment > 0 else 1.0,
        "at_zero": float(np.mean(samples == 0)) if low == 0 else 0.0,
        "at_top": float(np.mean(samples >= top_dn)) if high >= top_dn else 0.0,
        "single": float(np.mean(variance == 0)),
    }
    touched = low == 0 or high >= top_dn
    sigma, slope = 0.0, 1.0
    spread_out = not touched and float(mean.std()) > SPREAD_DN
    if spread_out:
        sigma, slope = noise_behind(moment)
    hidden = max(found["at_zero"], found["at_top"]) >= HIDDEN
    if hidden or found["single"] >= SINGLE or (spread_out and sigma < LEAST_DN):
        return Cell(
            mean_dn=float(mean.mean()),
            level_dn=mean,
            level_variance_dn2=moment / n,
            variance_dn2=0.0,
            variance_se_dn2=0.0,
            resolved=0.0,
            **found,
        )
    if spread_out and SAFE_DN <= sigma <= LOUD_DN:
        return Cell(
            mean_dn=float(mean.mean()),
            level_dn=mean,
            level_variance_dn2=moment / n + sawtooth(sigma),
            variance_dn2=sigma * sigma,
            variance_se_dn2=slope * float(variance.std(ddof=1)) / (h * w) ** 0.5,
            resolved=1.0,
            **found,
        )
    if moment - ROUNDING_DN2 > LOUD_DN**2 and not touched:
        return Cell(
            mean_dn=float(mean.mean()),
            level_dn=mean,
            level_variance_dn2=moment / n,
            variance_dn2=moment - ROUNDING_DN2,
            variance_se_dn2=moment * (2 / (h * w * (n - 1))) ** 0.5,
            resolved=1.0,
            **found,
        )
    q = basis(row, column, min(PRIOR_DEGREE, highest(h, w)))
    centre = q @ (q.T @ mean)
    left = mean - centre
    pattern = float(left @ left) / max(h * w - q.shape[1], 1) - moment / n
    fit = fit_codes(
        count_codes(samples, low, high),
        low,
        top_dn,
        q,
        centre=centre,
        sigma=max(moment - ROUNDING_DN2, 0.25 * moment) ** 0.5,
        tau=max(pattern, 1e-4) ** 0.5,
    )
    return Cell(
        mean_dn=float(fit.centre_dn.mean()),
        level_dn=fit.level_dn,
        level_variance_dn2=fit.level_variance_dn2,
        variance_dn2=fit.variance_dn2,
        variance_se_dn2=fit.variance_se_dn2,
        resolved=fit.resolved,
        **found,
    )


def _moments(samples: NDArray[Any]) -> tuple[Floats, Floats, Floats]:
    """Mean and unbiased variance of each site (n,), and mean of each frame (N,)."""
    n = len(samples)
    base = int(samples[0].mean())
    d = samples.astype(np.float32)
    d -= base
    total = d.sum(axis=0, dtype=np.float64)
    squares = np.einsum("ij,ij->j", d, d, dtype=np.float64)
    variance = (squares - total * total / n) / (n - 1)
    return base + total / n, np.maximum(variance, 0.0), base + d.mean(axis=1, dtype=np.float64)
