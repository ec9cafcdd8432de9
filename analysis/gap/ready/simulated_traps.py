"""Simulated pixels with a trap and without one, in the darks of a body, and what they show.

Random numbers are the same whatever the traps: figures of traps that hardly differ hardly differ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from analysis.gap.ready.loud_pixels import Ground, Loud, Stack, figures_of, summary
from sensor.effects.random_telegraph_noise import RandomTelegraphNoise

Floats = NDArray[np.float64]

TRAPS = 12_000
"""Simulated, of all grounds together."""

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
        exponential, normal: numbers of each trap, of which either tells how far it jumps.
        forgets, forgotten: by shot and frame, whether a trap forgets its level, and which is next.
        shot: by shot and frame, noise of a jump that is dark current, in its own.
        dn: by shot and frame, the pixel without a trap, before it is rounded.
        without: figures of as many pixels as there are samples, without a trap; see `figures_of`.
    """

    exponential: Stack
    normal: Stack
    forgets: list[Stack]
    forgotten: list[Stack]
    shot: list[Stack]
    dn: list[Stack]
    without: Floats


def chances_of(pixels: Loud) -> list[Chances]:
    """The random numbers for every ground.

    Args:
        pixels: the loud ones of a body, that they will be held against.
    """
    return [
        _chances(ground, pixels, np.random.default_rng(k))
        for k, ground in enumerate(pixels.grounds)
    ]


def figures_with(traps: RandomTelegraphNoise, pixels: Loud, drawn: list[Chances]) -> Floats:
    """Figures of the loud ones among pixels with and without traps; see `summary`.

    Args:
        traps: the traps.
        pixels: those of the body.
        drawn: the random numbers of every ground.
    """
    total = np.zeros(len(pixels.seen))
    for ground, chances in zip(pixels.grounds, drawn, strict=True):
        sizes = traps.sizes(chances.exponential, chances.normal)
        shots = []
        for k, interval_s in enumerate(ground.intervals_s):
            stays = np.exp(-interval_s / traps.tau_s)
            up = chances.forgotten[k] < traps.share_up
            for frame in range(1, len(up)):
                kept = chances.forgets[k][frame] < stays
                up[frame] = np.where(kept, up[frame - 1], up[frame])
            jump_e = np.float32(traps.mean_e(ground.darkness_s[k])) * sizes * up
            if traps.of_dark_current:
                jump_e += np.sqrt(jump_e) * chances.shot[k]
            shots.append(np.rint(chances.dn[k] + np.float32(ground.gain_dn_per_e) * jump_e))
        with_trap = figures_of(shots, ground, pixels.quartiles).sum(axis=1) / len(sizes)
        total += traps.fraction * ground.samples * with_trap
        total += (1.0 - traps.fraction) * chances.without
    return summary(total, pixels.samples)


def _chances(ground: Ground, pixels: Loud, rng: np.random.Generator) -> Chances:
    """Traps for one ground, of all sizes in the shares that their distribution has."""
    grounds = len(pixels.grounds)
    traps = TRAPS // grounds
    rank = rng.permutation((np.arange(traps) + 0.5) / traps)
    quiet = _noise(ground, QUIET // grounds, rng)
    of_quiet = figures_of([np.rint(dn) for dn in quiet], ground, pixels.quartiles)
    shapes = [(frames, traps) for frames in ground.frames]
    return Chances(
        exponential=-np.log1p(-rank).astype(np.float32),
        normal=special.ndtri(rank).astype(np.float32),
        forgets=[rng.random(shape, dtype=np.float32) for shape in shapes],
        forgotten=[rng.random(shape, dtype=np.float32) for shape in shapes],
        dn=_noise(ground, traps, rng),
        without=of_quiet.sum(axis=1) * ground.samples / (QUIET // grounds),
        shot=[rng.standard_normal(shape, dtype=np.float32) for shape in shapes],
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
