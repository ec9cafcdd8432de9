"""Gains behind a converter of finer codes than leave the camera, told by their combs.

Several gains have teeth at almost the same places. Where the comb begins and how deep its teeth are
tells them apart.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.look.comb import GAINS, LEAST_CODES, LEAST_COUNT, MOST_CODES, WINDOW, taken

Floats = NDArray[np.float64]

SHORT = np.array([1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0]) / 64.0
"""What a histogram is without its teeth, where these are no more than three codes apart."""

OF_ITSELF = 0.02
"""Part of a histogram by which it is uneven without any comb."""

GAIN_STEP = 2e-4
FARTHEST = 0.2
"""Part of a gain, as photon transfer tells it, by which converters of colours may differ."""

FINER_STEPS = 21

AS_DEEP = 0.35
"""Part by which teeth may be less deep than a comb's, or deeper. Gains of quarters leave teeth that
are like those of some gain of whole codes, and a third as deep."""

NEAR_BLACK = np.linspace(-0.15, 0.15, 7)
"""From a black level, as whole codes tell it, to where it may be."""

QUARTERS = 4
"""Steps of a code in which gains leave clear combs; those of sixteenths are lost in the picture."""

LIKE_A_FINER = 0.65
"""Correlation of a histogram with the comb of the gain that it has: 0.84 to 0.98 where this was
tuned. Without gains of quarters the best had 0.1 to 0.55."""

CLEARLY = 0.1
"""By how much more a histogram is like a comb of finer codes than like one of whole codes."""


def finer_gain(
    counts: Floats, steps: float, about: float, black_dn: float, origins_dn: Floats
) -> float | None:
    """The gain that a channel has behind a converter of finer steps; None without a comb of one.

    A code has the steps that a gain puts into it: 3 or 4 quarters at a gain of 1.2, in an order
    that is almost that of some other gains, whose combs begin elsewhere.

    Args:
        counts: histogram of lit shots.
        steps: of the converter in a code.
        about: the gain, roughly.
        black_dn: black level.
        origins_dn: what it may leave as it is.
    """
    wide = about + np.arange(-FARTHEST * about, FARTHEST * about, GAIN_STEP)
    _, near = _likest(counts, steps, wide, black_dn, origins_dn)
    closer = near + np.linspace(-GAIN_STEP, GAIN_STEP, FINER_STEPS)
    alike, gain = _likest(counts, steps, closer, black_dn, origins_dn)
    return gain if alike > LIKE_A_FINER else None


def of_finer_codes(counts: Mapping[str, Floats], steps: float, black_dn: float) -> bool:
    """Whether red or blue has the comb of a gain of finer codes, and less of one of whole codes.

    Args:
        counts: histograms of lit shots, by channel.
        steps: of the converter in a finer code.
        black_dn: black level.
    """
    origins_dn = np.append(black_dn + NEAR_BLACK, 0.0)
    for channel in ("R", "B"):
        finer, whole = (
            _likest(counts[channel], n, GAINS, black_dn, origins_dn)[0] for n in (steps, 1.0)
        )
        if finer > max(LIKE_A_FINER, whole + CLEARLY):
            return True
    return False


def _likest(
    counts: Floats, steps: float, gains: Floats, black_dn: float, origins_dn: Floats
) -> tuple[float, float]:
    """How much a histogram is like the best of those combs of some gains that are as deep as its
    own, and that gain.
    """
    smooth = ndimage.convolve1d(counts, SHORT, mode="constant")
    at = np.flatnonzero(ndimage.minimum_filter1d(smooth, len(SHORT)) > LEAST_COUNT)
    at = at[at > black_dn + WINDOW]
    if len(at) < LEAST_CODES or len(counts) > MOST_CODES:
        return 0.0, 1.0
    error = np.sqrt(1.0 / smooth[at] + OF_ITSELF**2)
    seen = (counts[at] / smooth[at] - 1.0) / error
    whole = np.arange(len(counts) * steps)[:, None] / steps
    alike = np.zeros(len(gains))
    for origin in origins_dn:
        hits = taken(origin + (whole - origin) * gains, len(counts))
        comb = hits / np.maximum(ndimage.convolve1d(hits, SHORT, axis=0), 1e-9) - 1.0
        comb = comb[at] / error[:, None]
        power = np.maximum(np.square(comb).sum(axis=0), 1e-9)
        along = seen @ comb
        as_deep = np.abs(along / power - 1.0) < AS_DEEP
        one = np.where(as_deep, along / np.sqrt(power * np.square(seen).sum()), 0.0)
        alike = np.maximum(alike, one)
    best = int(np.argmax(alike))
    return float(alike[best]), float(gains[best])
