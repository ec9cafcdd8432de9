"""How many photosites jump between two levels, how far, and how long they stay on each.

Traps that jump by less than their noise are seen in no frame, and those that jump far are seen in
the frames of their pixels. Both make pixels loud, and what these show (`loud`) is held against
simulated pixels with a trap, of the same noise, in as many frames, that were looked at by the same
code: indirect inference. With f(traps) the mean of their figures, s those of the frames and C their
covariance over pixels, the traps are those of the least

    (s - f)' C^-1 (s - f)

and C and the slopes of f give their errors. Figures more than there are parameters say
whether it is traps at all: other noise does not stay as long as its size and its number demand.
Jumps are the same in any exposure, or dark current where that leaves more than chance. How far
they jump is told by two laws, the likelier one first.
A fit by twins cannot do as well: a few dozen pixels of theirs jump, others and at other times.

Source of the method: Gourieroux, Monfort and Renault, Indirect inference, J. Applied Econometrics
8, 1993.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from analysis.gap.ready.hints import FEWEST_OF_A_DWELL, DirectReading
from analysis.gap.ready.loud_pixels import (
    AFTER_ONE_FRAME,
    BETWEEN_CODES_DN2,
    HOW_LOUD,
    Loud,
    loud,
)
from analysis.gap.ready.moments import gains_of
from analysis.gap.ready.setting import Setting
from analysis.gap.ready.simulated_traps import chances_of, figures_with
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise

Floats = NDArray[np.float64]

LEAST_NUMBER = 16
"""Loud pixels that tell traps, their number to a quarter."""

LEAST_STAYS = 0.05
"""What is left of a loud pixel after one frame, with two standard errors to spare: less is noise of
another kind."""

CHANCE = 1e-4
"""Of what is left of the figures, below which it was no traps."""

UNLIKELY = 0.05
"""The same, below which traps are looked for by another law, and from another spread."""

LEAST_TIMES = 1.5
"""Between the shortest and the longest exposure that tell one law from the other."""

LEAST_TOLD = 1.0
"""Standard error of a logarithm from which a figure is not told. A fit by twins would give it a
smaller one, and not for better reasons."""

MOST_SHOTS = 6
"""Dark shots that are looked at: each has to be simulated."""

STEP = 0.1
"""In logarithms, by which slopes are read: a trap more or less is loud at every smaller one."""

WIDE = 2.0
"""Standard deviation of ln(t_up / t_down) before any frame was seen."""

STEPS = 25
"""Of a fit, at most."""

RANGE = (
    np.append(np.log([1e-6, 0.1, 1e-2, 1e-3]), 0.0),
    np.append(np.log([0.3, 1e4, 1e2, 10.0]), 2.0),
)
"""Least and most of share, jump in electrons, t_up / t_down, and correlation time in s, as
logarithms, and of the spread of the jumps: what the effect can be, and what a shot can tell."""

MOST_ALIKE = 1e12
"""Ratio of the variances of what is best and what is worst told, from which numbers end."""

FIRST_RATIOS = (0.5, 2.0)
FIRST_FRAMES = 4.0
FIRST_SIZE = 3.0
ALIKE = 0.2
"""Where searches begin: t_up / t_down, correlation time in frames, jump in standard errors of noise
where jumps differ, and how little they do where they are alike."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Fit:
    """Traps of a law that come nearest to what loud pixels show.

    Attributes:
        law: which.
        at: logarithms of what it is fitted by, and the spread; see `RANGE`.
        wider: factor of variances, where more is left than chance leaves.
        chance: of what is left.
        told: inverse of the covariance of `at`.
    """

    law: RandomTelegraphNoise
    at: Floats
    wider: float
    chance: float
    told: Floats


def trapped(setting: Setting) -> DirectReading | None:
    """Share of photosites with a trap, amplitude and dwell times; None where too few pixels are
    loud, or not in the way of traps.

    Args:
        setting: the capture.
    """
    darks = setting.darks(FEWEST_OF_A_DWELL)[:MOST_SHOTS]
    return told_by_loud(loud(darks, setting.scenery.view.lattices, gains_of(setting)))


def told_by_loud(pixels: Loud) -> DirectReading | None:
    """Share of photosites with a trap, amplitude and dwell times, by the loud pixels of one body;
    None where these are too few, or not in the way of traps.

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
    drawn = chances_of(pixels)

    def fitted(law: RandomTelegraphNoise, beginnings: Iterable[Floats]) -> _Fit:
        def off(at: Floats) -> Floats:
            expected = figures_with(_as_told(law, at), pixels, drawn)
            return np.append(weight @ (expected - seen), at[2] / WIDE)

        def slopes(at: Floats) -> Floats:
            steps = STEP * np.eye(len(at))
            there = [np.clip([at - s, at + s], *RANGE) for s in steps]
            return np.transpose([(off(up) - off(down)) / np.sum(up - down) for down, up in there])

        fits = [
            optimize.least_squares(off, at, slopes, bounds=RANGE, max_nfev=STEPS)
            for at in beginnings
        ]
        best = min(fits, key=lambda one: one.cost)
        freedom = len(seen) + 1 - len(RANGE[0])
        slope = np.asarray(best.jac, dtype=np.float64)
        return _Fit(
            law=law,
            at=best.x,
            wider=max(2.0 * best.cost / freedom, 1.0),
            chance=_by_chance(2.0 * best.cost, freedom, pixels.pixels),
            told=slope.T @ slope,
        )

    laws = [RandomTelegraphNoise()]
    if _exposed_differently(pixels):
        laws.append(RandomTelegraphNoise(of_dark_current=1.0))
    fits: list[_Fit] = []
    # whatever fits is not looked for by another law, nor from another spread
    for law, alike in itertools.product(laws, (False, True)):
        fits.append(fitted(law, _beginnings(pixels, alike=alike)))
        if fits[-1].chance >= UNLIKELY:
            break
    best = max(fits, key=lambda one: one.chance)
    inside = np.clip(best.at, RANGE[0] + STEP, RANGE[1] - STEP)
    other = fitted(dataclasses.replace(best.law, lognormal=1.0), [inside])
    likelier, other = sorted((best, other), key=lambda one: -one.chance)
    first, second = _told(likelier), _told(other)
    return dataclasses.replace(first, instead=second) if first else second


def _exposed_differently(pixels: Loud) -> bool:
    """Whether the exposures of the darks tell jumps of dark current from others."""
    darkness_s = pixels.grounds[0].darkness_s
    return max(darkness_s) > LEAST_TIMES * min(darkness_s)


def _by_chance(left: float, freedom: int, pixels: int) -> float:
    """How likely so much is left of traps: Hotelling's test, whose covariance is of few pixels."""
    more = pixels - freedom
    return float(stats.f.sf(left * more / (freedom * (pixels - 1)), freedom, more))


def _as_told(law: RandomTelegraphNoise, at: Floats) -> RandomTelegraphNoise:
    """Traps by logarithms of share, jump in electrons, t_up / t_down and correlation time in s, and
    by the spread of their jumps.
    """
    fraction, amplitude_e, ratio, tau_s = map(float, np.exp(at[:4]))
    values = {
        "fraction": fraction,
        "amplitude_e": amplitude_e,
        "dwell_up_s": tau_s * (1.0 + ratio),
        "dwell_down_s": tau_s * (1.0 + ratio) / ratio,
        "spread": float(at[4]),
    }
    ranges = {p.name: p for p in law.parameters()}
    inside = {name: ranges[name].clipped(value) for name, value in values.items()}
    return dataclasses.replace(law, **inside)


def _told(found: _Fit) -> DirectReading | None:
    """Parameters and their errors; None where it was no traps, or nobody can tell."""
    if found.chance < CHANCE or np.linalg.cond(found.told) > MOST_ALIKE:
        return None
    traps = _as_told(found.law, found.at)
    share_up = traps.share_up
    # d ln(t_up) = d ln(tau) + share_up d ln(ratio), of t_down less one d ln(ratio)
    ways = np.eye(5)
    ways[2:4, 2:4] = [[share_up, 1.0], [share_up - 1.0, 1.0]]
    covariance = ways @ (found.wider * np.linalg.inv(found.told)) @ ways.T
    *relative, of_spread = np.sqrt(np.diag(covariance))
    if max(relative) > LEAST_TOLD:
        return None
    values = {p.name: float(getattr(traps, p.name)) for p in traps.parameters()}
    scales = ("fraction", "amplitude_e", "dwell_up_s", "dwell_down_s")
    errors = {name: values[name] * float(r) for name, r in zip(scales, relative, strict=True)}
    return DirectReading(hints=values, errors=errors | {"spread": float(of_spread)})


def _beginnings(pixels: Loud, *, alike: bool) -> list[Floats]:
    """Where fits begin; see `RANGE`.

    A jump A that is half of the time up has the variance A^2 / 4; of jumps that differ the loud
    ones are the largest.

    Args:
        pixels: the loud ones.
        alike: whether jumps hardly differ.
    """
    ground = pixels.grounds[0]
    share = 3.0 * pixels.pixels / pixels.samples
    noise_dn = np.sqrt(max(ground.variances_dn2[0], BETWEEN_CODES_DN2))
    louder = np.expm1(pixels.seen[HOW_LOUD])
    size, spread = (2.0 * np.sqrt(max(louder, 1.0)), ALIKE) if alike else (FIRST_SIZE, 1.0)
    jump_e = size * noise_dn / ground.gain_dn_per_e
    tau_s = FIRST_FRAMES * ground.intervals_s[0]
    lowest, highest = RANGE
    return [
        np.clip(
            np.append(np.log([share, jump_e, ratio, tau_s]), spread), lowest + STEP, highest - STEP
        )
        for ratio in FIRST_RATIOS
    ]
