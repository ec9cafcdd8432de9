"""Gains behind a converter of more bits than leave the camera, told by where codes end.

A code takes whole steps of the converter: at a gain of 1.2 and four steps in a code, 3 or 4 of
them, in an order that tells the gain to 1e-4.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.look.code_edges import CodeEdges
from sensor.effects.white_balance import WhiteBalance

Floats = NDArray[np.float64]

LEAST_ERROR = 0.01
"""Of a gain by photon transfer, relative to it, where noise is not quite of photons."""

FARTHEST = 4.0
"""Such errors by which a gain may be off."""

GAIN_STEP = 6.4e-4
"""Over steps in a code: part of a gain that moves no tooth of 250 codes by a sixth of a step."""

CLOSER = np.linspace(-1.0, 1.0, 13)
"""Parts of that step, around gains that are looked at closely."""

SHARPER = 3
"""Times that a fourth of that step is looked at, around the gain that is taken."""

ALIKE = 0.1
"""Of chi-squared, by which gains are alike that put all teeth in the same places."""

PEAK = 25
"""Such steps over which one gain is looked at closely."""

MOST_CLOSER = 24
"""Gains that are: of two with almost the same comb the first look may prefer the wrong one."""

BLACK_ERROR_DN = 0.1
"""Of a black level that whole codes of the shortest darks tell."""

ORIGINS = 3.0 * np.linspace(-1.0, 1.0, 21)
ORIGINS_CLOSER = 3.0 * np.linspace(-1.0, 1.0, 121)
"""Such errors by which the code is off that gains leave alone: the first edges of a comb are told
best, by darks, and move by a step at some black level or other."""

DARK_CODES = 3
"""Codes on either side of black that darks have."""

RIVAL = 12.0
"""Of chi-squared, by which another comb may be worse and be the right one all the same: in darks
of less noise than pixels' means can tell it shows at once."""

MOST_RIVALS = 4

FITS = 1.5
"""Chi-squared over what chance has of it, in codes whose edges are told."""

AT_ONCE = 4096
"""Combs that are in memory together."""


@dataclass(frozen=True, kw_only=True)
class Gains:
    """A white balance behind the converter.

    Attributes:
        white_balance: the gains.
        origin_dn: the code that they leave alone; None where nothing tells it.
        fall: of chi-squared of red and blue.
        likely: that less what photon transfer and darks say against gains and origin.
    """

    white_balance: WhiteBalance
    origin_dn: float | None = None
    fall: float = 0.0
    likely: float = 0.0


def finer_gains(edges: Mapping[str, CodeEdges], steps: float, black_dn: float) -> tuple[Gains, ...]:
    """The likeliest gains of red and blue, about the black level or code 0; none where codes end
    elsewhere all the same.
    """
    tried: list[Gains] = []
    for about_black in (1.0, 0.0):
        near, closer = (
            black_dn + BLACK_ERROR_DN * off if about_black else np.zeros(1)
            for off in (ORIGINS, ORIGINS_CLOSER)
        )
        red, blue = (_by_origin(edges[c], edges["G"], steps, near, closer) for c in "RB")
        unlikely = np.square((closer - black_dn * about_black) / BLACK_ERROR_DN)
        likely = red.likely[:, None] + blue.likely - unlikely
        of_darks = int(black_dn) + np.arange(-DARK_CODES, DARK_CODES + 1)
        seen: set[tuple[float, ...]] = set()
        for at in np.argsort(-likely, axis=None):
            of_red, of_blue, of_origin = np.unravel_index(at, likely.shape)
            if likely.flat[at] < likely.max() - RIVAL or len(seen) == MOST_RIVALS:
                break
            gains = np.array([red.gains[of_red, of_origin], blue.gains[of_blue, of_origin]])
            origin_dn = float(closer[of_origin])
            firsts = first_steps(gains, np.full(2, origin_dn), steps, of_darks)
            place = (of_red, of_blue, *firsts.ravel())
            if place in seen:
                continue
            seen.add(place)
            (red_gain, red_fall), (blue_gain, blue_fall) = (
                _sharper(edges[c], steps, float(k), origin_dn)
                for c, k in zip("RB", gains, strict=True)
            )
            if fits(edges["R"], red_fall) and fits(edges["B"], blue_fall):
                balance = WhiteBalance(
                    red_gain=red_gain, blue_gain=blue_gain, about_black=about_black
                )
                tried.append(
                    Gains(
                        white_balance=balance,
                        origin_dn=origin_dn,
                        fall=red_fall + blue_fall,
                        likely=float(likely.flat[at]),
                    )
                )
    tried.sort(key=lambda one: -one.likely)
    return tuple(one for one in tried if one.likely > tried[0].likely - RIVAL)[:MOST_RIVALS]


def _sharper(own: CodeEdges, steps: float, gain: float, origin_dn: float) -> tuple[float, float]:
    """A gain as sharply as a comb tells it, and by how much it makes chi-squared less."""
    fall, width = 0.0, GAIN_STEP / steps * gain
    for _ in range(SHARPER):
        gains = gain + width * CLOSER
        falls = own.fall(comb(gains, np.full(len(gains), origin_dn), steps, own.codes))
        # between the first and the last of those that are alike
        best = gains[falls > falls.max() - ALIKE]
        gain, fall, width = float((best[0] + best[-1]) / 2.0), float(falls.max()), width / 4.0
    return gain, fall


class ByOrigin(NamedTuple):
    """Likely gains for each code that gains may leave alone, (peaks, origins) each: themselves, and
    how much less chi-squared is by them, less what photon transfer says against them.
    """

    gains: Floats
    likely: Floats


def _by_origin(
    own: CodeEdges, green: CodeEdges, steps: float, near_dn: Floats, closer_dn: Floats
) -> ByOrigin:
    """The likeliest gains of a channel.

    Gains that differ by about one step in a code have almost the same comb: photon transfer tells
    them apart.
    """
    about = own.noise_slope_dn / green.noise_slope_dn
    error = about * float(np.hypot(np.hypot(own.slope_error, green.slope_error), LEAST_ERROR))

    def looked_at(gains: Floats, origins_dn: Floats) -> Floats:
        each, origins = (grid.ravel() for grid in np.meshgrid(gains, origins_dn, indexing="ij"))
        parts = [
            own.fall(comb(k, o, steps, own.codes))
            for k, o in zip(_pieces(each), _pieces(origins), strict=True)
        ]
        falls = np.concatenate(parts).reshape(len(gains), -1)
        return np.asarray(falls - np.square((gains[:, None] - about) / error))

    far, step = FARTHEST * error, GAIN_STEP / steps * about
    gains = about + np.arange(-far, far, step)
    best = looked_at(gains, near_dn).max(axis=1)
    peaks = np.flatnonzero(ndimage.maximum_filter1d(best, PEAK) == best)
    peaks = peaks[np.argsort(-best[peaks])[:MOST_CLOSER]]
    closer = gains[peaks, None] + step * CLOSER
    likely = looked_at(closer.ravel(), closer_dn).reshape(*closer.shape, -1)
    return ByOrigin(
        gains=np.take_along_axis(closer, likely.argmax(axis=1), axis=1), likely=likely.max(axis=1)
    )


def _pieces(values: Floats) -> list[Floats]:
    return [values[k : k + AT_ONCE] for k in range(0, len(values), AT_ONCE)]


def comb(gains: Floats, origins_dn: Floats, steps: float, codes: NDArray[np.intp]) -> Floats:
    """Where codes end whose converter counts in steps of them, with a gain behind it.

    Step j comes out as o + k (j / steps - o), and is a code's if that rounds to it. An edge is half
    a step in front of the first. Where halves go is lost in any gain but 1.

    Args:
        gains, origins_dn: k and o, (n,) each.
        steps: of the converter in a code.
        codes: whose lower edges.

    Returns:
        How far these are from half-way between codes, in codes, (n, codes).
    """
    k, begin = gains[:, None], (origins_dn * (1.0 - gains))[:, None]
    first = first_steps(gains, origins_dn, steps, codes)
    return np.asarray(k / steps * (first - 0.5) + begin - (codes - 0.5))


def first_steps(gains: Floats, origins_dn: Floats, steps: float, codes: NDArray[np.intp]) -> Floats:
    """The first step of each code, (n, codes); see `comb`."""
    k, begin = gains[:, None], (origins_dn * (1.0 - gains))[:, None]
    return np.asarray(np.ceil((codes - 0.5 - begin) * steps / k - 1e-9))


def fits(own: CodeEdges, fall: float) -> bool:
    """Whether codes end where they should but for chance, with so much off chi-squared."""
    return own.chi2 - fall < FITS * own.figures
