"""How many photosites jump between two levels, how far, and how long they stay on each.

Traps that jump by less than their noise are seen in no frame, and those that jump far are seen in
the frames of their pixels. Both make pixels loud, and what these show (`loud`) is held against
simulated pixels with a trap, of the same noise, in as many frames, that were looked at by the same
code: indirect inference. With f(traps) the mean of their figures, s those of the frames and C their
covariance over pixels, the traps are those of the least

    (s - f)' C^-1 (s - f)

and C and the slopes of f give their errors. Four figures more than there are parameters say
whether it is traps at all: other noise does not stay as long as its size and its number demand.
Jumps are exponential, or all alike where that leaves more than chance.
A fit by twins cannot do as well: a few dozen pixels of theirs jump, others and at other times.

Source of the method: Gourieroux, Monfort and Renault, Indirect inference, J. Applied Econometrics
8, 1993.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats

from analysis.gap.ready.hints import FEWEST_OF_A_DWELL, Told
from analysis.gap.ready.loud import (
    AFTER_ONE_FRAME,
    BETWEEN_CODES_DN2,
    HOW_LOUD,
    Ground,
    Loud,
    Stack,
    figures_of,
    loud,
    summary,
)
from analysis.gap.ready.moments import gains_of
from analysis.gap.ready.setting import Setting

Floats = NDArray[np.float64]

LEAST_NUMBER = 16
"""Loud pixels that tell traps, their number to a quarter."""

LEAST_STAYS = 0.05
"""What is left of a loud pixel after one frame, with two standard errors to spare: less is noise of
another kind."""

CHANCE = 1e-4
"""Of what is left of the figures, below which it was no traps."""

UNLIKELY = 0.05
"""The same of jumps that are exponential, below which they may be all alike."""

LEAST_TOLD = 1.0
"""Standard error of a logarithm from which a figure is not told. A fit by twins would give it a
smaller one, and not for better reasons."""

MOST_SHOTS = 6
"""Dark shots that are looked at: each has to be simulated."""

TRAPS = 12_000
"""Simulated, of all grounds together."""

STEP = 0.1
"""In logarithms, by which slopes are read: a trap more or less is loud at every smaller one."""

WIDE = 2.0
"""Standard deviation of ln(t_up / t_down) before any frame was seen."""

STEPS = 25
"""Of a fit, at most."""

RANGE = tuple(np.log([[1e-6, 0.1, 1e-2, 1e-3], [0.3, 1e4, 1e2, 1e3]]))
"""Least and most of share, jump in electrons, t_up / t_down, and correlation time in s: what the
effect can be."""

MOST_ALIKE = 1e12
"""Ratio of the variances of what is best and what is worst told, from which numbers end."""

FIRST_RATIOS = (0.5, 2.0)
FIRST_FRAMES = 4.0
FIRST_SIZE = 3.0
"""Where searches begin: t_up / t_down, correlation time, and jump in standard errors of noise."""

QUIET = 120_000
"""Simulated pixels without a trap, of which a few are loud."""

FEW = 2000
"""Of them tell the median of their variances."""

SIGMA_DN = 1e-3
"""To which noise is found."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Chances:
    """The random numbers of simulated traps in one ground, the same for all parameters.

    Attributes:
        size: of each jump, in mean jumps, where they are not alike.
        forgets, forgotten: by shot and frame, whether a trap forgets its level, and which is next.
        dn: by shot and frame, the pixel without a trap, before it is rounded.
        without: figures of as many pixels as there are samples, without a trap; see `figures_of`.
    """

    size: Stack
    forgets: list[Stack]
    forgotten: list[Stack]
    dn: list[Stack]
    without: Floats


def trapped(setting: Setting) -> Told | None:
    """Share of photosites with a trap, amplitude and dwell times; None where too few pixels are
    loud, or not in the way of traps.

    Args:
        setting: the capture.
    """
    darks = setting.darks(FEWEST_OF_A_DWELL)[:MOST_SHOTS]
    return told_by_loud(loud(darks, setting.scenery.view.lattices, gains_of(setting)))


def told_by_loud(pixels: Loud) -> Told | None:
    """The same of the loud pixels of a body.

    Args:
        pixels: of its darks.
    """
    if pixels.pixels < LEAST_NUMBER:
        return None
    seen, covariance = pixels.seen, pixels.covariance
    stays, error = seen[AFTER_ONE_FRAME], np.sqrt(covariance[AFTER_ONE_FRAME, AFTER_ONE_FRAME])
    if stays - 2.0 * error < LEAST_STAYS or np.linalg.cond(covariance) > MOST_ALIKE:
        return None
    weight = np.linalg.cholesky(np.linalg.inv(covariance)).T
    drawn = [
        _chances(ground, pixels, np.random.default_rng(k))
        for k, ground in enumerate(pixels.grounds)
    ]

    def fitted(alike: bool, begin: Floats) -> optimize.OptimizeResult:
        def off(at: Floats) -> Floats:
            expected = _figures(at, alike, pixels, drawn)
            return np.append(weight @ (expected - seen), at[2] / WIDE)

        def slopes(at: Floats) -> Floats:
            steps = STEP * np.eye(len(at))
            return np.transpose([(off(at + s) - off(at - s)) / (2.0 * STEP) for s in steps])

        return optimize.least_squares(off, begin, slopes, bounds=RANGE, max_nfev=STEPS)

    def best_of(alike: bool) -> optimize.OptimizeResult:
        fits = [fitted(alike, at) for at in _beginnings(pixels, alike)]
        return min(fits, key=lambda one: one.cost)

    def chance(one: optimize.OptimizeResult) -> float:
        return _by_chance(2.0 * one.cost, freedom, pixels.pixels)

    freedom = len(seen) + 1 - len(RANGE[0])
    alike, best = False, best_of(False)
    if chance(best) < UNLIKELY and (other := best_of(True)).cost < best.cost:
        alike, best = True, other
    slope = np.asarray(best.jac, dtype=np.float64)
    told = slope.T @ slope
    if chance(best) < CHANCE or np.linalg.cond(told) > MOST_ALIKE:
        return None
    wider = max(2.0 * best.cost / freedom, 1.0)
    return _told(best.x, alike, np.asarray(wider * np.linalg.inv(told), dtype=np.float64))


def _by_chance(left: float, freedom: int, pixels: int) -> float:
    """How likely so much is left of traps: Hotelling's test, whose covariance is of few pixels."""
    more = pixels - freedom
    return float(stats.f.sf(left * more / (freedom * (pixels - 1)), freedom, more))


def _told(at: Floats, alike: bool, covariance: Floats) -> Told | None:
    """Parameters and their errors, from logarithms and theirs."""
    fraction, amplitude_e, ratio, tau_s = map(float, np.exp(at))
    share_up = ratio / (1.0 + ratio)
    hints = {
        "fraction": fraction,
        "amplitude_e": amplitude_e,
        "dwell_up_s": tau_s * (1.0 + ratio),
        "dwell_down_s": tau_s * (1.0 + ratio) / ratio,
    }
    law = {"alike": float(alike)}
    # d ln(t_up) = d ln(tau) + share_up d ln(ratio), of t_down less one d ln(ratio)
    ways = np.array(
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, share_up, 1], [0, 0, share_up - 1.0, 1]], dtype=float
    )
    relative = np.sqrt(np.diag(ways @ covariance @ ways.T))
    if relative.max() > LEAST_TOLD:
        return None
    errors = {
        name: value * float(r) for (name, value), r in zip(hints.items(), relative, strict=True)
    }
    return Told(hints=hints | law, errors=errors)


def _beginnings(pixels: Loud, alike: bool) -> list[Floats]:
    """Logarithms of share, jump in electrons, t_up / t_down, and correlation time in s.

    A jump A that is half of the time up has the variance A^2 / 4; of jumps that differ the loud
    ones are the largest.
    """
    ground = pixels.grounds[0]
    share = 3.0 * pixels.pixels / pixels.samples
    noise_dn = np.sqrt(max(ground.variances_dn2[0], BETWEEN_CODES_DN2))
    louder = np.expm1(pixels.seen[HOW_LOUD])
    size = 2.0 * np.sqrt(max(louder, 1.0)) if alike else FIRST_SIZE
    jump_e = size * noise_dn / ground.gain_dn_per_e
    tau_s = FIRST_FRAMES * ground.intervals_s[0]
    lowest, highest = RANGE
    return [
        np.clip(np.log([share, jump_e, ratio, tau_s]), lowest + STEP, highest - STEP)
        for ratio in FIRST_RATIOS
    ]


def _chances(ground: Ground, pixels: Loud, rng: np.random.Generator) -> Chances:
    """Traps for one ground, of all sizes in the shares that an exponential has."""
    grounds = len(pixels.grounds)
    traps = TRAPS // grounds
    size = rng.permutation(-np.log1p(-(np.arange(traps) + 0.5) / traps))
    quiet = _noise(ground, QUIET // grounds, rng)
    of_quiet = figures_of([np.rint(dn) for dn in quiet], ground, pixels.quartiles)
    shapes = [(frames, traps) for frames in ground.frames]
    return Chances(
        size=size.astype(np.float32),
        forgets=[rng.random(shape, dtype=np.float32) for shape in shapes],
        forgotten=[rng.random(shape, dtype=np.float32) for shape in shapes],
        dn=_noise(ground, traps, rng),
        without=of_quiet.sum(axis=1) * ground.samples / (QUIET // grounds),
    )


def _noise(ground: Ground, pixels: int, rng: np.random.Generator) -> list[Stack]:
    """Pixels without a trap in every shot, (frames, pixels), before they are rounded: at levels
    that there are, with the noise whose median of variances is the one seen."""
    at = rng.integers(ground.samples, size=pixels)
    made = []
    shots = zip(ground.frames, ground.variances_dn2, ground.levels_dn, strict=True)
    for frames, typical_dn2, levels_dn in shots:
        normal = rng.standard_normal((frames, pixels), dtype=np.float32)
        level = levels_dn[at].astype(np.float32)
        sigma_dn = _before_rounding(normal[:, :FEW], level[:FEW], typical_dn2)
        made.append(level + np.float32(sigma_dn) * normal)
    return made


def _before_rounding(normal: Stack, level: Stack, typical_dn2: float) -> float:
    """Standard deviation of noise that shows so much variance in the typical pixel, in DN."""

    def too_loud(sigma_dn: float) -> float:
        shown = np.rint(level + np.float32(sigma_dn) * normal)
        return float(np.median(shown.var(axis=0, ddof=1))) - typical_dn2

    if typical_dn2 <= 0:
        return 0.0
    return float(optimize.bisect(too_loud, 0.0, np.sqrt(typical_dn2) + 1.0, xtol=SIGMA_DN))


def _figures(at: Floats, alike: bool, pixels: Loud, drawn: list[Chances]) -> Floats:
    """Figures of the loud ones among pixels with and without traps; see `summary`."""
    fraction, amplitude_e, _, tau_s = np.exp(at)
    share_up = special.expit(at[2])
    total = np.zeros(len(pixels.seen))
    for ground, chances in zip(pixels.grounds, drawn, strict=True):
        one_dn = np.float32(amplitude_e * ground.gain_dn_per_e)
        jumps_dn = np.full_like(chances.size, one_dn) if alike else one_dn * chances.size
        shots = []
        for k, interval_s in enumerate(ground.intervals_s):
            stays = np.exp(-interval_s / tau_s)
            up = chances.forgotten[k] < share_up
            for frame in range(1, len(up)):
                kept = chances.forgets[k][frame] < stays
                up[frame] = np.where(kept, up[frame - 1], up[frame])
            shots.append(np.rint(chances.dn[k] + jumps_dn * up))
        with_trap = figures_of(shots, ground, pixels.quartiles).sum(axis=1) / len(chances.size)
        total += fraction * ground.samples * with_trap + (1.0 - fraction) * chances.without
    return summary(total, pixels.samples)
