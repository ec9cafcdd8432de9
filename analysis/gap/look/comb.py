"""Curves behind the converter, told by the comb that they leave in the codes.

Whole codes that are multiplied or bent, and rounded again, leave out some codes and take others
twice. Noise and light make histograms smooth, so that nothing else has such teeth, and each curve
has its own: a gain of 1.2 leaves out every sixth code.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.look.lattices import Lattice
from sensor.colours import CHANNELS
from sensor.effects.white_balance import WhiteBalance

Floats = NDArray[np.float64]

FRAMES = 16
"""Frames of a shot whose codes are counted."""

MOST_CODES = 256
"""Finer codes than these hardly show whether they were rounded twice."""

WINDOW = 15
"""Codes over which a histogram is smooth; a comb has several teeth in them."""

LEAST_COUNT = 40
"""Samples of a code that make its count worth a look."""

LEAST_CODES = 30

WINDOWED = 512
"""Of finer codes so many are looked at for a gain, which shows in every dozen of them."""

STEP = 64
"""Such windows begin at multiples of this, so that channels have most of them in common."""

GAINS = np.round(np.arange(0.67, 2.0, 5e-4), 4)
OFFSETS = np.arange(0.0, 2.0, 0.1)
EXPONENTS = np.round(np.arange(0.3, 2.0, 2e-4), 4)

COARSER = 5
"""Of these powers every fifth is tried about a black level."""

ORIGINS = np.arange(-0.6, 0.61, 0.15)
"""Where a curve about black begins, from a first black level: noise that it bends moves that."""

FINER_ORIGINS = np.linspace(-0.1, 0.1, 5)

SLACK = 0.02
"""By how much less a comb may be like the histogram and still fit as well."""

AS_GOOD_AS_ZERO = 0.15

NEAR = 0.03
"""A gain or an exponent nearer to 1 than this has too few teeth."""

ALIKE = 0.57
"""Correlation of a histogram with the comb of a gain that it has; others have up to 0.5."""

MORE = 0.1
"""By how much more a histogram is like its comb than that of green is like any: where noise is low,
patches of a chart have teeth of their own, and few codes are like some gain by chance."""

BENT_ALIKE = 0.45
"""The same of a power, whose teeth are few where it is steep; others have 0.3."""


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


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A power of all that is above an origin, in parts of what is between that and the top."""

    exponent: float
    origin_dn: float


def histograms(
    stacks: Sequence[NDArray[Any]], lattices: Sequence[Lattice], top_dn: int
) -> dict[str, Floats]:
    """How often each channel has each code, (top_dn + 1,).

    Args:
        stacks: frames of some shots.
        lattices: where the measured samples are.
        top_dn: the largest pixel value.
    """
    found = {lattice.channel: np.zeros(top_dn + 1) for lattice in lattices}
    for lattice in lattices:
        for dn in stacks:
            codes = lattice.of(dn[:FRAMES]).ravel().astype(np.int64)
            found[lattice.channel] += np.bincount(codes, minlength=top_dn + 1)[: top_dn + 1]
    return found


def white_balance(counts: Mapping[str, Floats], step: int = 1) -> WhiteBalance | None:
    """Gains of whole red and blue codes against green; None where neither has the comb of one.

    Args:
        counts: histograms by channel.
        step: from one code of the converter to the next, where its lowest bits are lost.
    """
    if set(counts) != set(CHANNELS):
        return None
    found = _gains_of(counts, step)
    # where green has a comb as well, all codes are counted in other steps
    other_steps = step == 1 and found["G"] is not None
    if other_steps or (found["R"] is None and found["B"] is None):
        return None
    red, blue = found["R"] or (1.0, False), found["B"] or (1.0, False)
    if red[0] == blue[0] == 1.0:
        return None
    return WhiteBalance(red_gain=red[0], blue_gain=blue[0], about_black=float(red[1] or blue[1]))


def _gains_of(counts: Mapping[str, Floats], step: int) -> dict[str, tuple[float, bool] | None]:
    """Gain of each histogram, and whether it leaves a black level alone; None without a comb."""
    # where steps are wide a gain of 1 has a comb as well
    near = NEAR if step == 1 else 0.0
    first = {channel: _first(one) for channel, one in counts.items()}
    teeth = {channel: _teeth(one[first[channel] :][:WINDOWED]) for channel, one in counts.items()}
    found: dict[str, list[tuple[float, float, float]]] = {channel: [] for channel in counts}
    for low in {first[channel] for channel, one in teeth.items() if one is not None}:
        size = min(WINDOWED, len(counts["G"]) - low)
        # a gain below 1 fills a window from more codes than it has, if there are more
        whole = np.floor(low / GAINS) + np.arange(min(2 * size, len(counts["G"])))[:, None]
        whole = whole[::step] // step * step
        for at in step * OFFSETS:
            combs = _combs(whole * GAINS + at - low, size)
            for channel, one in teeth.items():
                if one is not None and first[channel] == low:
                    found[channel].append((*_fitting(one, GAINS, combs, near), float(at)))
    chance = max((alike for alike, _, _ in found["G"]), default=0.0) if step == 1 else 0.0
    least = {channel: ALIKE if channel == "G" else max(ALIKE, chance + MORE) for channel in found}
    return {channel: _roundest_pair(one, least[channel]) for channel, one in found.items()}


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
        if finer > max(LIKE_A_FINER, whole + MORE):
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
        taken = _taken(origin + (whole - origin) * gains, len(counts))
        comb = taken / np.maximum(ndimage.convolve1d(taken, SHORT, axis=0), 1e-9) - 1.0
        comb = comb[at] / error[:, None]
        power = np.maximum(np.square(comb).sum(axis=0), 1e-9)
        along = seen @ comb
        as_deep = np.abs(along / power - 1.0) < AS_DEEP
        one = np.where(as_deep, along / np.sqrt(power * np.square(seen).sum()), 0.0)
        alike = np.maximum(alike, one)
    best = int(np.argmax(alike))
    return float(alike[best]), float(gains[best])


def _first(counts: Floats) -> int:
    """Where to look in a histogram: at all of few codes, of many from the first frequent one."""
    often = np.flatnonzero(counts > LEAST_COUNT)
    if len(counts) <= WINDOWED or len(often) == 0:
        return 0
    return min(int(often[0]), len(counts) - WINDOWED) // STEP * STEP


def _roundest_pair(
    found: Sequence[tuple[float, float, float]], least: float
) -> tuple[float, bool] | None:
    """Of likeness, gain and offset the gain that fits, and whether there is an offset.

    A little more gain is a little less offset: the roundest pair of those that fit alike.
    """
    best = max((alike for alike, _, _ in found), default=0.0)
    if best < least:
        return None
    _, off_zero, gain = min(
        (len(f"{gain:g}"), not _nothing(at, gain), gain)
        for one, gain, at in found
        if one > best - SLACK
    )
    return gain, off_zero


def _nothing(offset: float, gain: float) -> bool:
    """Whether an offset is some whole codes' worth of gain, so that the codes begin at 0."""
    beyond = offset % gain
    return bool(min(beyond, gain - beyond) < AS_GOOD_AS_ZERO)


def curve(counts: Mapping[str, Floats], black_dn: float) -> Curve | None:
    """The power that bends whole codes of all channels; None without a comb of one.

    Args:
        counts: histograms by channel.
        black_dn: a first black level.
    """
    whole = np.sum(list(counts.values()), axis=0)
    if len(whole) > MOST_CODES:
        return None
    teeth = _teeth(whole)
    if teeth is None:
        return None

    def best(origins: Floats, exponents: Floats) -> tuple[float, float, float]:
        return max((*_power(teeth, len(whole), float(at), exponents), float(at)) for at in origins)

    about_zero = best(np.zeros(1), EXPONENTS)
    _, near, origin = best(black_dn + ORIGINS, EXPONENTS[::COARSER])
    nearly = EXPONENTS[np.abs(EXPONENTS - near) < NEAR]
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
    return _fitting(teeth, exponents, _combs(curves, size), NEAR)


def powered(codes: Floats, top: float, origin: float, exponents: Floats | float) -> Floats:
    """Codes whose part of the range above an origin is raised to a power, on either side of it."""
    x = (codes - origin) / (top - origin)
    return np.asarray(origin + (top - origin) * np.sign(x) * np.abs(x) ** exponents)


Teeth = tuple[NDArray[np.intp], Floats]
"""Codes away from the ends of a histogram, and how much they differ from their surroundings."""


def _teeth(counts: Floats) -> Teeth | None:
    """What is uneven in a histogram, (codes,); None where it has too few codes to tell."""
    smooth = ndimage.uniform_filter1d(counts, WINDOW, mode="constant")
    # the ends have slopes of their own
    at = np.flatnonzero(ndimage.minimum_filter1d(smooth, WINDOW) > LEAST_COUNT)
    if len(at) < LEAST_CODES:
        return None
    seen = counts[at] / smooth[at]
    return at, np.clip(seen - seen.mean(), -1.0, 1.0)


def _combs(curves: Floats, size: int) -> Floats:
    """How often each code is hit, over how often those around it are, (size, n).

    Args:
        curves: what becomes of each whole code, (codes, n).
        size: number of codes; what is beyond is clipped.
    """
    taken = _taken(curves, size)
    around = ndimage.uniform_filter1d(taken, WINDOW, axis=0)
    return np.asarray(taken / np.maximum(around, 1e-9))


def _taken(curves: Floats, size: int) -> Floats:
    """How often each code is hit, (size, n); see `_combs`."""
    count = curves.shape[1]
    places = np.clip(np.rint(curves), 0, size - 1).astype(np.int64) + size * np.arange(count)
    taken = np.bincount(places.ravel(), minlength=size * count).reshape(count, size).T
    return taken.astype(np.float64)


def _fitting(teeth: Teeth, figures: Floats, combs: Floats, near: float) -> tuple[float, float]:
    """The figure whose comb is most like a histogram: how much, and which.

    Args:
        teeth: of the histogram.
        figures: one for each comb, (n,).
        combs: see `_combs`, (codes, n).
        near: figures that are nearer to 1 are out of the question.
    """
    at, seen = teeth
    comb = combs[at] - combs[at].mean(axis=0)
    norm = np.sqrt(np.square(comb).sum(axis=0) * np.square(seen).sum())
    likeness = np.where(np.abs(figures - 1) >= near, seen @ comb / np.maximum(norm, 1e-9), 0.0)
    return float(likeness.max()), _roundest(figures[likeness > likeness.max() - SLACK])


def _roundest(alike: Floats) -> float:
    """Of figures that fit alike, the one with fewest decimals: people set them."""
    return float(min(alike, key=lambda figure: (len(f"{figure:g}"), abs(figure - alike.mean()))))
