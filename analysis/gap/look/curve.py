"""A power that bends whole codes, told by their comb."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.comb import (
    MANY_ORIGINS,
    MOST_CODES,
    NEAR,
    OF_FEW_TEETH,
    SLACK,
    WINDOW,
    Teeth,
    combs,
    few_teeth_of,
    fitting,
    like_few,
    teeth_of,
)

Floats = NDArray[np.float64]

EXPONENTS = np.round(np.arange(0.3, 2.0, 2e-4), 4)
"""Powers that are tried."""

NEARLY_STRAIGHT = EXPONENTS[(np.abs(EXPONENTS - 1) < NEAR) & (np.abs(EXPONENTS - 1) > 0.0035)]
"""Powers whose combs have one tooth or a few."""

COARSER = 5
"""Of these powers every fifth is tried about a black level."""

ORIGINS = np.arange(-0.6, 0.61, 0.15)
"""Where a curve about black begins, from a first black level: noise that it bends moves that."""

CHORD = 0.025
"""Part of the range up to which there may be a straight line, and teeth of its own."""

FINER_ORIGINS = np.linspace(-0.1, 0.1, 5)
"""Where a curve begins, from the likeliest of `ORIGINS`, in DN."""

BENT_ALIKE = 0.45
"""Correlation of a histogram with the comb of a power that it has, whose teeth are few where it is
steep; others have 0.3."""


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A power of all that is above an origin, in parts of what is between that and the top."""

    exponent: float
    origin_dn: float

    @property
    def sharp(self) -> bool:
        """Whether its comb has so many teeth that it tells the power to the last digit."""
        return abs(self.exponent - 1.0) >= NEAR


def curve(counts: Mapping[str, Floats], black_dn: float) -> Curve | None:
    """The power that bends whole codes of all channels; None without a comb of one.

    Args:
        counts: histograms by channel.
        black_dn: a first black level.
    """
    whole = np.sum(list(counts.values()), axis=0)
    if len(whole) > MOST_CODES:
        return None
    teeth = teeth_of(whole)
    if teeth is None:
        return None

    def best(origins: Floats, exponents: Floats) -> tuple[float, float, float]:
        return max((*_power(teeth, len(whole), float(at), exponents), float(at)) for at in origins)

    about_zero = best(np.zeros(1), EXPONENTS)
    _, about, origin = best(black_dn + ORIGINS, EXPONENTS[::COARSER])
    nearly = EXPONENTS[np.abs(EXPONENTS - about) < NEAR]
    about_black = best(origin + FINER_ORIGINS, nearly)
    # code 0 is where whole pictures are bent, and one origin of many is as good by chance
    alike, exponent, origin = max(about_zero, (about_black[0] - SLACK, *about_black[1:]))
    return Curve(exponent=exponent, origin_dn=origin) if alike > BENT_ALIKE else None


def _power(teeth: Teeth, size: int, origin: float, exponents: Floats) -> tuple[float, float]:
    """How much a histogram is like the comb of a power about an origin, and its exponent."""
    at, seen = teeth
    # darks end in a tooth that is no curve's
    beyond = at > origin + WINDOW if origin else at >= 0
    teeth = at[beyond], seen[beyond]
    curves = powered(np.arange(float(size))[:, None], size - 1, origin, exponents)
    return fitting(teeth, exponents, combs(curves, size), NEAR)


def nearly_straight(counts: Mapping[str, Floats], black_dn: float) -> Curve | None:
    """A power that is nearly 1, by the one tooth or the few that its comb has in all channels; None
    without such teeth.

    Args:
        counts: histograms by channel.
        black_dn: a first black level.
    """
    size = len(next(iter(counts.values())))
    few = few_teeth_of(list(counts.values())) if size <= MOST_CODES else None
    if few is None:
        return None
    beyond = few[0] > black_dn + CHORD * size
    teeth = few[0][beyond], few[1][beyond]
    codes = np.arange(float(size))[:, None]
    found: list[tuple[float, float, float]] = []
    for origin in (0.0, *(black_dn + MANY_ORIGINS)):
        of_powers = combs(powered(codes, size - 1, origin, NEARLY_STRAIGHT), size)
        found.append((*like_few(teeth, NEARLY_STRAIGHT, of_powers), float(origin)))
    told, exponent, origin = max(found)
    return Curve(exponent=exponent, origin_dn=origin) if told > OF_FEW_TEETH else None


def powered(codes: Floats, top: float, origin: float, exponents: Floats | float) -> Floats:
    """Codes whose part of the range above an origin is raised to a power, on either side of it."""
    x = (codes - origin) / (top - origin)
    return np.asarray(origin + (top - origin) * np.sign(x) * np.abs(x) ** exponents)
