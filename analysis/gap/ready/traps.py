"""How many photosites jump between two levels, how far, and how long they stay on each.

Traps that jump by less than their noise are seen in no frame, and those that jump far are seen in
the frames of their pixels. Both make pixels loud, and what these show (`loud`) is held against
simulated pixels with a trap, of the same noise, in as many frames, that were looked at by the same
code: indirect inference. With f(traps) the mean of their figures, s those of the frames and C their
covariance over pixels, the traps are those of the least

    (s - f)' C^-1 (s - f)

and C and the slopes of f give their errors. Three figures more than there are parameters say
whether it is traps at all: other noise does not stay as long as its size and its number demand.
A fit by twins cannot do as well: a few dozen pixels of theirs jump, others and at other times.

Source of the method: Gourieroux, Monfort and Renault, Indirect inference, J. Applied Econometrics
8, 1993.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.ready.hints import FEWEST_OF_A_DWELL, Told
from analysis.gap.ready.loud import Ground, Loud, figures_of, loud, summary
from analysis.gap.ready.moments import gains_of
from analysis.gap.ready.setting import Setting

Floats = NDArray[np.float64]

LEAST_NUMBER = 24
"""Loud pixels that tell traps, their number to a fifth."""

LEAST_STAYS = 0.05
"""What is left of a loud pixel after one frame, with two standard errors to spare: less is noise of
another kind."""

CHANCE = 1e-3
"""Of what is left of the figures, below which it was no traps."""

LEAST_TOLD = 0.5
"""Standard error of a logarithm from which a figure is not told."""

TRAPS = 12_000
"""Simulated, of all grounds together: twenty times as many as are seen at most."""

STEP = 0.1
"""In logarithms, by which slopes are read: a trap more or less is loud at every smaller one."""

WIDE = 2.0
"""Standard deviation of ln(t_up / t_down) before any frame was seen."""

FIRST_STAYS_FRAMES = (2.0, 8.0)
FIRST_RATIOS = (0.5, 2.0)
FIRST_SIZE = 3.0
"""Where searches begin: correlation times, t_up / t_down, and jumps in standard errors of noise."""

LEAST_NOISE_DN2 = 0.003
"""Of a frame before it is rounded."""


@dataclass(frozen=True, kw_only=True)
class Chances:
    """The random numbers of simulated traps in one ground, the same for all parameters.

    Attributes:
        size: of each jump, in mean jumps.
        forgets, forgotten: of each frame, whether a trap forgets its level, and which one is next.
        noise_dn: of each frame, about a level that lies anywhere between two codes.
    """

    size: NDArray[np.float32]
    forgets: NDArray[np.float32]
    forgotten: NDArray[np.float32]
    noise_dn: NDArray[np.float32]


def trapped(setting: Setting) -> Told | None:
    """Share of photosites with a trap, amplitude and dwell times; None where too few pixels are
    loud, or not in the way of traps.

    Args:
        setting: the capture.
    """
    darks = [s for s in setting.key_frames if s.shot.dark and s.count >= FEWEST_OF_A_DWELL]
    return told_by_loud(loud(darks, setting.scenery.view.lattices, gains_of(setting)))


def told_by_loud(pixels: Loud) -> Told | None:
    """The same of the loud pixels of a body.

    Args:
        pixels: of its darks, whose frames follow each other at one interval.
    """
    if pixels.pixels < LEAST_NUMBER:
        return None
    seen, covariance = pixels.seen, pixels.covariance
    if seen[2] - 2.0 * np.sqrt(covariance[2, 2]) < LEAST_STAYS:
        return None
    weight = np.linalg.cholesky(np.linalg.inv(covariance)).T
    drawn = [_chances(ground, len(pixels.grounds), k) for k, ground in enumerate(pixels.grounds)]

    def off(at: Floats) -> Floats:
        expected = _figures(at, pixels, drawn)
        return np.append(weight @ (expected - seen), at[2] / WIDE)

    def slopes(at: Floats) -> Floats:
        steps = STEP * np.eye(len(at))
        return np.transpose([(off(at + s) - off(at - s)) / (2.0 * STEP) for s in steps])

    fits = [optimize.least_squares(off, at, slopes, max_nfev=25) for at in _beginnings(pixels)]
    best = min(fits, key=lambda one: one.cost)
    left, freedom = 2.0 * best.cost, len(seen) + 1 - len(best.x)
    if stats.chi2.sf(left, freedom) < CHANCE:
        return None
    wider = max(left / freedom, 1.0)
    of_logarithms = wider * np.linalg.inv(best.jac.T @ best.jac)
    return _told(best.x, of_logarithms)


def _told(at: Floats, covariance: Floats) -> Told | None:
    """Parameters and their errors, from logarithms and theirs."""
    fraction, amplitude_e, ratio, tau_s = map(float, np.exp(at))
    share_up = ratio / (1.0 + ratio)
    hints = {
        "fraction": fraction,
        "amplitude_e": amplitude_e,
        "dwell_up_s": tau_s * (1.0 + ratio),
        "dwell_down_s": tau_s * (1.0 + ratio) / ratio,
    }
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
    return Told(hints=hints, errors=errors)


def _beginnings(pixels: Loud) -> list[Floats]:
    """Logarithms of share, jump in electrons, t_up / t_down, and correlation time in s."""
    ground = pixels.grounds[0]
    share = 3.0 * pixels.pixels * len(pixels.grounds) / pixels.samples
    jump_e = FIRST_SIZE * np.sqrt(ground.variance_dn2) / ground.gain_dn_per_e
    return [
        np.log([min(share, 0.3), jump_e, ratio, frames * ground.interval_s])
        for ratio in FIRST_RATIOS
        for frames in FIRST_STAYS_FRAMES
    ]


def _chances(ground: Ground, grounds: int, seed: int) -> Chances:
    """Traps for one ground, of all sizes in the shares that an exponential has."""
    rng = np.random.default_rng(seed)
    traps = TRAPS // grounds
    shape = (ground.frames, traps)
    sigma_dn = np.sqrt(max(ground.variance_dn2 - ROUNDING_DN2, LEAST_NOISE_DN2))
    noise = sigma_dn * rng.standard_normal(shape) + rng.uniform(size=traps)
    return Chances(
        size=rng.permutation(-np.log1p(-(np.arange(traps) + 0.5) / traps)).astype(np.float32),
        forgets=rng.random(shape, dtype=np.float32),
        forgotten=rng.random(shape, dtype=np.float32),
        noise_dn=noise.astype(np.float32),
    )


def _figures(at: Floats, pixels: Loud, drawn: list[Chances]) -> Floats:
    """Figures of the loud ones among pixels with traps; see `summary`."""
    fraction, amplitude_e, _, tau_s = np.exp(at)
    share_up = special.expit(at[2])
    total = np.zeros(len(pixels.seen))
    for ground, chances in zip(pixels.grounds, drawn, strict=True):
        stays = np.exp(-ground.interval_s / tau_s)
        up = chances.forgotten < share_up
        for frame in range(1, ground.frames):
            kept = chances.forgets[frame] < stays
            up[frame] = np.where(kept, up[frame - 1], up[frame])
        jumps_dn = np.float32(amplitude_e * ground.gain_dn_per_e) * chances.size
        dn = np.rint(chances.noise_dn + jumps_dn * up)
        figures = figures_of(dn, ground)[1].sum(axis=1)
        total += fraction * ground.samples / len(chances.size) * figures
    return summary(total, pixels.samples)
