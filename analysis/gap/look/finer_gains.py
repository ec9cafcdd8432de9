"""Gains behind a converter of more bits than leave the camera, told by where codes end.

A code takes whole steps of the converter: at a gain of 1.2 and four steps in a code, 3 or 4 of
them, in an order that tells the gain to 1e-4.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.look.code_edges import CodeEdges
from foundation.cores import in_order
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

PEAK = 11
"""Such steps over which one gain is looked at closely."""

MOST_CLOSER = 12
"""Gains that are, about each origin: of two with almost the same comb the first look may prefer the
wrong one."""

BLACK_ERROR_DN = 0.1
"""Of a black level that whole codes of the shortest darks tell."""

ORIGINS = 3.0 * np.linspace(-1.0, 1.0, 61)
"""Such errors by which the code is off that gains leave alone: the first edges of a comb are told
best, by darks, and move by a step at some black level or other. Likely gains are looked for about
each, as the likeliest of one colour may need an origin that another colour rules out."""

ORIGINS_CLOSER = 0.075 * np.linspace(-1.0, 1.0, 7)
"""The same around an origin that is looked at closely."""

DARK_CODES = 3
"""Codes on either side of black that darks have."""

RIVAL = 12.0
"""Of chi-squared, by which another comb may be worse and be the right one all the same: in darks
of less noise than pixels' means can tell it shows at once."""

MOST_RIVALS = 4
"""Such combs, the likeliest among them, that are kept at most."""

MOST_PAIRS = 12
"""Gains of two colours that are looked at as sharply as combs tell them."""

BEHIND = 40.0
"""Of chi-squared, by which the right ones may be behind others before that."""

AS_FAR = 9.0
"""Of chi-squared, that edges which are some times as far off may take off besides, times what
chance has of it in these codes."""

ABOUT_AS_FAR = 0.04
"""The same as a part of the power of the edges: of 82 gains of 41 cameras it was 1.4 % at most
where the power was above 500, and below that 5.1 at most. Behind another demosaicer, which had made
codes uneven, gains that were none had 20 to 500 beside a power of 7 to 25."""

FITS = 1.5
"""Chi-squared over what chance has of it, in codes whose edges are told."""

A_LOOK = np.linspace(-1.0, 1.0, 256)
"""Parts of the farthest error of a gain, whose combs are like those of all others."""

AT_ONCE = 512
"""Combs that are in memory together: as many as a core's cache holds."""

HALVES = 1e-9
"""Of a step, by which one that is half-way but for rounding counts for the code above."""


@dataclass(frozen=True, kw_only=True)
class Gains:
    """A white balance behind the converter.

    Attributes:
        white_balance: the gains.
        origin_dn: the code that they leave alone; None where nothing tells it.
        falls: of chi-squared, of red and of blue.
        likely: their sum less what photon transfer and darks say against gains and origin.
    """

    white_balance: WhiteBalance
    origin_dn: float | None = None
    falls: tuple[float, ...] = ()
    likely: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """What a channel tells of its gain.

    Attributes:
        edges: where its codes end.
        steps: of the converter in a code.
        about: the gain by photon transfer.
        error: its standard error.
    """

    edges: CodeEdges
    steps: float
    about: float
    error: float

    @staticmethod
    def of(own: CodeEdges, green: CodeEdges, steps: float) -> Channel:
        """Of a channel behind the same converter as green."""
        about = own.noise_slope_dn / green.noise_slope_dn
        error = float(np.hypot(np.hypot(own.slope_error, green.slope_error), LEAST_ERROR))
        return Channel(edges=own, steps=steps, about=about, error=about * error)

    def falls(self, gains: Floats, origins_dn: Floats) -> Floats:
        """By how much gains about origins make chi-squared less, in the shape of both together."""
        each, origins = np.broadcast_arrays(gains, origins_dn)
        parts = [
            self.edges.fall(comb(k, o, self.steps, self.edges.codes))
            for k, o in zip(_pieces(each.ravel()), _pieces(origins.ravel()), strict=True)
        ]
        return np.concatenate(parts).reshape(each.shape)

    def as_far(self, gain: float, origin_dn: float, fall: float) -> bool:
        """Whether edges are as far off as a gain puts them, and not only in that direction.

        Args:
            gain, origin_dn: the gain and what it leaves alone.
            fall: of chi-squared by it.
        """
        edges = comb(np.array([gain]), np.array([origin_dn]), self.steps, self.edges.codes)[0]
        by_chance = max(1.0, (self.edges.chi2 - fall) / max(self.edges.figures, 1))
        allowed = AS_FAR * by_chance + ABOUT_AS_FAR * self.edges.power(edges)
        return self.edges.off_scale(edges) < allowed

    def most_power(self, origin_dn: float) -> float:
        """Of the combs of gains that it may have: what chi-squared has of one that is there."""
        gains = self.about + FARTHEST * self.error * A_LOOK
        combs = comb(gains, np.full(len(gains), origin_dn), self.steps, self.edges.codes)
        return float(np.einsum("ij,ij->i", combs @ self.edges.information, combs).max())

    def against(self, gains: Floats) -> Floats:
        """Chi-squared of gains by photon transfer."""
        return np.square((gains - self.about) / self.error)


def finer_gains(
    edges: Mapping[str, CodeEdges], steps: float, black_dn: float, least_power: float
) -> tuple[Gains, ...]:
    """The likeliest gains of red and blue, about the black level or code 0; none where codes end
    elsewhere all the same, or where steps are so fine that their combs have less power.

    Args:
        edges: of red, green and blue.
        steps: of the converter in a code.
        black_dn: black level.
        least_power: of both combs together, from which they are looked for.
    """
    colours = [Channel.of(edges[c], edges["G"], steps) for c in "RB"]
    if sum(own.most_power(black_dn) for own in colours) < least_power:
        return ()
    found: list[Gains] = []
    for origin_dn in (black_dn, 0.0):
        far, near = (ORIGINS, ORIGINS_CLOSER) if origin_dn else (np.zeros(1), np.zeros(1))
        for gains, off in _pairs(colours, origin_dn, far):
            sharp = [_sharper(colours, gains, origin_dn, off + more) for more in near]
            found.append(max(sharp, key=lambda one: one.likely))
    rivals: dict[tuple[float, ...], Gains] = {}
    for one in sorted(found, key=lambda one: -one.likely):
        balance, about_dn = one.white_balance, float(one.origin_dn or 0.0)
        gains = np.array([balance.red_gain, balance.blue_gain])
        each = zip(colours, gains, one.falls, strict=True)
        if all(fits(own.edges, fall) and own.as_far(k, about_dn, fall) for own, k, fall in each):
            rivals.setdefault(_key(gains, about_dn, steps), one)
    likely = list(rivals.values())
    return tuple(one for one in likely if one.likely > likely[0].likely - RIVAL)[:MOST_RIVALS]


def _pairs(
    colours: Sequence[Channel], origin_dn: float, off: Floats
) -> Iterator[tuple[Floats, float]]:
    """Likely gains of both colours, (2,), each pair with other codes in the dark or gains that are
    not close, and of `off` what goes with them: errors by which the origin is off.
    """
    origins_dn = origin_dn + BLACK_ERROR_DN * off
    each = in_order(lambda own: _by_origin(own, origins_dn), colours)
    gains, likely = zip(*each, strict=True)
    of_both = likely[0][:, None] + likely[1] - np.square(off)
    seen: set[tuple[float, ...]] = set()
    for at in np.argsort(-of_both, axis=None):
        if len(seen) == MOST_PAIRS or of_both.flat[at] < of_both.max() - BEHIND:
            return
        *of, k = np.unravel_index(at, of_both.shape)
        pair = np.array([one[i, k] for one, i in zip(gains, of, strict=True)])
        key = _key(pair, float(origins_dn[k]), colours[0].steps)
        if key not in seen:
            seen.add(key)
            yield pair, float(off[k])


def _key(gains: Floats, origin_dn: float, steps: float) -> tuple[float, ...]:
    """What tells combs apart: the steps that codes of darks have, and gains as far as they are
    looked at closely.
    """
    codes = int(origin_dn) + np.arange(-DARK_CODES, DARK_CODES + 1)
    firsts = first_steps(gains, np.full(len(gains), origin_dn), steps, codes)
    peaks = np.round(np.log(gains) * steps / (PEAK * GAIN_STEP))
    return (*peaks.tolist(), *firsts.ravel().tolist())


def _by_origin(own: Channel, origins_dn: Floats) -> tuple[Floats, Floats]:
    """Likely gains of a channel about each origin, (gains, origins), and how much less chi-squared
    is by them, less what photon transfer says against them, the same.

    Gains that differ by about one step in a code have almost the same comb: photon transfer tells
    them apart.
    """
    far, step = FARTHEST * own.error, GAIN_STEP / own.steps * own.about
    gains = own.about + np.arange(-far, far, step)
    likely = own.falls(gains[:, None], origins_dn) - own.against(gains)[:, None]
    likely[ndimage.maximum_filter1d(likely, PEAK, axis=0) > likely] = -np.inf
    peaks = np.argsort(-likely, axis=0)[:MOST_CLOSER]
    closer = gains[peaks] + step * CLOSER[:, None, None]
    likely = own.falls(closer, origins_dn) - own.against(closer)
    best = likely.argmax(axis=0)[None]
    return np.take_along_axis(closer, best, axis=0)[0], likely.max(axis=0)


def _sharper(colours: Sequence[Channel], gains: Floats, origin_dn: float, off: float) -> Gains:
    """Gains as sharply as combs tell them, about an origin that is so many errors off."""
    about_dn = float(origin_dn + BLACK_ERROR_DN * off)
    ends = [_sharply(own, float(k), about_dn) for own, k in zip(colours, gains, strict=True)]
    (red, _), (blue, _) = ends
    against = [float(own.against(np.array(k))) for own, (k, _) in zip(colours, ends, strict=True)]
    falls = tuple(fall for _, fall in ends)
    return Gains(
        white_balance=WhiteBalance(red_gain=red, blue_gain=blue, about_black=float(origin_dn > 0)),
        origin_dn=about_dn,
        falls=falls,
        likely=float(sum(falls) - sum(against) - off**2),
    )


def _sharply(own: Channel, gain: float, origin_dn: float) -> tuple[float, float]:
    """One gain, and by how much it makes chi-squared less."""
    fall, width = 0.0, GAIN_STEP / own.steps * gain
    for _ in range(SHARPER):
        gains = gain + width * CLOSER
        falls = own.falls(gains, np.array([origin_dn]))
        # between the first and the last of those that are alike
        best = gains[falls > falls.max() - ALIKE]
        gain, fall, width = float((best[0] + best[-1]) / 2.0), float(falls.max()), width / 4.0
    return gain, fall


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
    half_ways = _steps_to(codes, gains, origins_dn, steps)
    away = np.ceil(half_ways - HALVES)
    away -= half_ways
    away -= 0.5
    away *= gains[:, None] / steps
    return away


def first_steps(gains: Floats, origins_dn: Floats, steps: float, codes: NDArray[np.intp]) -> Floats:
    """The first step of each code, (n, codes); see `comb`."""
    return np.ceil(_steps_to(codes, gains, origins_dn, steps) - HALVES)


def _steps_to(codes: NDArray[np.intp], gains: Floats, origins_dn: Floats, steps: float) -> Floats:
    """Steps at which a converter comes out half-way below each code, (n, codes)."""
    k, begin = gains[:, None], (origins_dn * (1.0 - gains))[:, None]
    return np.asarray((codes - 0.5 - begin) * (steps / k))


def fits(own: CodeEdges, fall: float) -> bool:
    """Whether codes end where they should but for chance, with so much off chi-squared."""
    return own.chi2 - fall < FITS * own.figures
