"""Where one code ends and the next begins, told by each pixel's own mean.

The mean of a pixel over some frames and its noise tell how often its other frames should have each
code, if all codes were equally wide. What a histogram differs by from the sum over the pixels is
where edges of codes lie elsewhere: no picture, no fixed pattern and no light is as uneven. An edge
that lies d higher moves f d samples from the code above to the one below, where f is the density of
samples there. Means of pixels are lower by phi d as well, where phi is the density of their noise
at the edge, and what is expected of them goes along: edges that wander over more codes than noise
reaches would hardly show. So it is with the noise, which is read from the same codes. With all of
it the edges of a channel are a linear regression:

    counts - expected = F_n+1 - F_n + nuisances,    counts of Poisson
    F_n = f_n d_n - sum_m K_nm d_m,    K_nm = sum over samples phi_n phi_m + of their noise

Nuisances are a shift and a width of the noise, the waves of a histogram that are longer than a
comb, and in darks, which have few codes, the skewness and the kurtosis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.look.lattices import Lattice
from sensor.frames import Frames

Floats = NDArray[np.float64]

FINE = 16
"""Steps of a code in which the density of samples is kept."""

BEYOND = 16
"""Codes beyond the ends of the range into which noise may reach."""

LEVELS = 48
"""Parts of the pixels, by their means, that have a noise of their own."""

FEWEST_FRAMES = 4
"""Of a shot: two halves, each of which has a mean."""

MOST_SAMPLES = 400_000
"""Of a channel in a shot; more tell the same."""

LEAST_COUNT = 40
"""Samples of a code that make its count worth a look."""

LEAST_CODES = 6
"""Such codes that a shot must have for the edges of codes to be told from their counts."""

LEAST_NOISE_DN2 = 0.35
"""Noise below which the mean of whole codes does not tell where between them a pixel is."""

REACH = 5.0
"""Standard deviations of noise beyond which it moves no mean."""

LOUD = 6.0
"""Standard errors by which the noise of a pixel is beyond that of others and it takes no part."""

WAVE = 12
"""Codes in half of the shortest wave that may be the picture's."""

OF_ITSELF = 0.003
"""Part of its count that a code may be off, because noise is not quite normal."""

CLIPPED = 0.9
"""Part of the range from which noise tells no gain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CodeEdges:
    """What the histograms of a channel tell of the edges of its codes.

    Edge n is the lower one of code n; where all codes are equally wide it is at n - 1/2.

    Attributes:
        codes: those of whose lower edge they tell anything, (edges,).
        pull: d of a regression that is flat otherwise is `information`^-1 times this, (edges,).
        information: inverse covariance of the edges, (edges, edges); singular.
        chi2: what counts differ by from codes that are equally wide.
        figures: counts less nuisances, of which that is the expectation by chance alone.
        noise_slope_dn: growth of the noise's variance with the mean: conversion in DN/e-.
        slope_error: its standard error, relative to itself.
    """

    codes: NDArray[np.intp]
    pull: Floats
    information: Floats
    chi2: float
    figures: int
    noise_slope_dn: float
    slope_error: float

    def fall(self, moved: Floats) -> Floats:
        """By how much edges that lie elsewhere make chi-squared less, (n,).

        Args:
            moved: from half-way between codes, in codes, (n, edges).
        """
        # of many at once; 32 bits tell chi-squared to a tenth
        of_32 = moved.astype(np.float32)
        cost = np.einsum("ij,ij->i", of_32 @ self.information.astype(np.float32), of_32)
        return np.asarray(2.0 * moved @ self.pull - cost)

    def power(self, moved: Floats) -> float:
        """Chi-squared of edges that lie elsewhere, if none of them was expected to."""
        return float(moved @ self.information @ moved)

    def off_scale(self, moved: Floats) -> float:
        """By how much chi-squared were less still, if these edges were as far off in other units.

        With P the power of edges d and x = d . pull, it is (x - P)^2 / P: a chi-squared of one
        degree of freedom of edges that lie there, and large of those along which something else is.

        Args:
            moved: from half-way between codes, in codes, (edges,).
        """
        power = self.power(moved)
        return float(moved @ self.pull - power) ** 2 / power if power > 0 else 0.0


def code_edges(shots: Sequence[Frames], lattices: Sequence[Lattice], channel: str) -> CodeEdges:
    """The edges of a channel's codes, from all shots.

    Args:
        shots: of one camera, 8 bits.
        lattices: where the measured samples are.
        channel: name of one.
    """
    own = [lattice for lattice in lattices if lattice.channel == channel]
    edges = shots[0].top_dn + 2
    pull, information = np.zeros(edges), np.zeros((edges, edges))
    chi2, figures, along, power = 0.0, 0, 0.0, 0.0
    for frames in shots:
        if frames.count < FEWEST_FRAMES:
            continue
        stack = _like_most(_stack(frames, own))
        means, noise_dn2, which = _levels(stack)
        seen = means < CLIPPED * frames.top_dn
        if not frames.shot.dark and seen.any():
            # a line through each shot: what is dark in it has more noise than its level tells
            weight = 1.0 / np.maximum(noise_dn2[seen], 0.1) ** 2
            off = means[seen] - np.average(means[seen], weights=weight)
            # the variance of m frames has a relative variance of 2 / (m - 1)
            weight *= (len(stack) - 1) * stack.shape[1] / LEVELS / 2.0
            along += float((weight * off * noise_dn2[seen]).sum())
            power += float((weight * off**2).sum())
        tell = (noise_dn2 > LEAST_NOISE_DN2)[which]
        counts = np.bincount(stack[:, tell].ravel(), minlength=edges - 1).astype(np.float64)
        means = _of_means(stack[:, tell], which[tell], edges - 1)
        # each half of the frames expects the other: a mean of m frames is off by noise / m
        widths_dn2 = np.maximum(noise_dn2, 0.0) * (1.0 + 2.0 / len(stack))
        rows = _regression(
            counts,
            _density(means, widths_dn2),
            _along(means, widths_dn2, edges),
            dark=frames.shot.dark,
        )
        if rows is None:
            continue
        slopes, off_by, nuisances = rows
        pull += slopes.T @ off_by
        information += slopes.T @ slopes
        chi2 += float(off_by @ off_by)
        figures += len(off_by) - nuisances
    told = np.flatnonzero(np.diag(information) > 0.0)
    return CodeEdges(
        codes=told,
        pull=pull[told],
        information=information[np.ix_(told, told)],
        chi2=chi2,
        figures=figures,
        noise_slope_dn=along / power if power else 0.0,
        slope_error=float(np.sqrt(power)) / along if along > 0 else np.inf,
    )


def _stack(frames: Frames, lattices: Sequence[Lattice]) -> NDArray[np.int64]:
    """Codes of an even number of frames, (frames, pixels)."""
    count = frames.count // 2 * 2
    pixels = sum(lattice.of(frames.dn[:1]).size for lattice in lattices)
    step = max(1, -(-count * pixels // MOST_SAMPLES))
    each = [lattice.of(frames.dn[:count]).reshape(count, -1)[:, ::step] for lattice in lattices]
    return np.concatenate(each, axis=1).astype(np.int64)


def _like_most(stack: NDArray[np.int64]) -> NDArray[np.int64]:
    """The pixels that are no louder than others of their level: those of a few that jump between
    two levels have no normal noise about their mean. Their median is where others are as well.
    """
    own_dn2 = stack.var(axis=0, ddof=1)
    in_turn = np.argsort(np.median(stack, axis=0), kind="stable")
    # the variance of m frames has a relative variance of 2 / (m - 1)
    loud = 1.0 + LOUD * np.sqrt(2.0 / (len(stack) - 1))
    levels = np.array_split(in_turn, LEVELS)
    quiet = [one[own_dn2[one] <= loud * np.median(own_dn2[one])] for one in levels if len(one)]
    return stack[:, np.sort(np.concatenate(quiet))]


def _levels(stack: NDArray[np.int64]) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Means of pixels of about one level, variance of their noise before it was rounded, and the
    level of each pixel.
    """
    means = stack.mean(axis=0)
    which = np.empty(len(means), np.intp)
    which[np.argsort(means, kind="stable")] = np.arange(len(means)) * LEVELS // len(means)
    size = np.maximum(np.bincount(which, minlength=LEVELS), 1)

    def of_level(values: Floats) -> Floats:
        return np.asarray(np.bincount(which, values, minlength=LEVELS) / size)

    return of_level(means), of_level(stack.var(axis=0, ddof=1)) - 1.0 / 12.0, which


def _of_means(stack: NDArray[np.int64], which: NDArray[np.intp], codes: int) -> Floats:
    """Samples by level and by the mean of their pixel in half of the frames, (levels, fine steps),
    from half a code below -`BEYOND` on; see `_at`.
    """
    means = np.zeros((LEVELS, (codes + 2 * BEYOND) * FINE))
    for part in (stack[0::2], stack[1::2]):
        at = ((part.mean(axis=0) + 0.5 + BEYOND) * FINE).astype(np.intp)
        np.add.at(means, (which, at), float(len(part)))
    return means


def _density(means: Floats, widths_dn2: Floats) -> Floats:
    """Expected samples per fine step, where those of a level scatter about the means of pixels."""
    size = means.shape[1]
    turns = np.fft.rfftfreq(size)
    smooth = np.exp(-2.0 * np.pi**2 * FINE**2 * widths_dn2[:, None] * turns**2)
    return np.fft.irfft((np.fft.rfft(means) * smooth).sum(axis=0), size)


def _along(means: Floats, widths_dn2: Floats, edges: int) -> Floats:
    """How what is expected goes along with edges that lie elsewhere, (edges, edges): K.

    An edge that is x above the mean of a pixel changes its variance by -2 phi x d, and that of a
    level by the mean over its pixels; noise that is wider by dv moves f'' dv / 2 of the samples.
    """
    found = np.zeros((edges, edges))
    for samples, width_dn2 in zip(means, widths_dn2, strict=True):
        if width_dn2 == 0.0 or not (here := np.flatnonzero(samples)).size:
            continue
        sigma = np.sqrt(width_dn2)
        at_dn = (here + 0.5) / FINE - 0.5 - BEYOND
        near = np.arange(
            max(int(at_dn[0] - REACH * sigma), 0),
            min(int(at_dn[-1] + REACH * sigma) + 2, edges),
        )
        off_dn = near[:, None] - 0.5 - at_dn
        phi = stats.norm.pdf(off_dn, scale=sigma)
        wider = (phi * off_dn) @ samples[here]
        found[np.ix_(near, near)] += (phi * samples[here]) @ phi.T
        found[np.ix_(near, near)] += np.outer(wider, wider) / (width_dn2 * samples.sum())
    return found


def _at(codes: NDArray[Any]) -> NDArray[np.intp]:
    return ((codes + 0.5 + BEYOND) * FINE).astype(np.intp)


def _regression(
    counts: Floats, density: Floats, along: Floats, *, dark: bool
) -> tuple[Floats, Floats, int] | None:
    """Slopes of counts along the edges and what counts are off by, in standard errors and less
    nuisances, and how many these are; None where too few codes tell anything.
    """
    edges = len(along)
    codes = np.flatnonzero(counts > LEAST_COUNT)
    codes = codes[(codes > 0) & (codes < edges - 2)]
    if len(codes) < LEAST_CODES:
        return None
    below, above = _at(codes - 0.5), _at(codes + 0.5)

    def at_edges(order: int) -> tuple[Floats, Floats]:
        """A derivative of the density, per code, at the lower and the upper edges."""
        curve: Floats = density * FINE
        for _ in range(order):
            curve = np.gradient(curve) * FINE
        return (curve[below] + curve[below - 1]) / 2.0, (curve[above] + curve[above - 1]) / 2.0

    cumulative = np.append(0.0, np.cumsum(density))
    expected = cumulative[above] - cumulative[below]
    errors = np.sqrt(counts[codes] + (OF_ITSELF * counts[codes]) ** 2)
    place = (codes - codes[0]) / np.ptp(codes)
    waves = 1 if dark else len(codes) // WAVE + 1
    nuisances = [expected * np.cos(np.pi * wave * place) for wave in range(waves)]
    for low, high in map(at_edges, range(4 if dark else 2)):
        nuisances.append(high - low)
    known, _ = np.linalg.qr(np.stack(nuisances, axis=1) / errors[:, None])
    low, high = at_edges(0)
    slopes = np.zeros((len(codes), edges))
    row = np.arange(len(codes))
    slopes[row, codes] = -low / errors
    slopes[row, codes + 1] = high / errors
    slopes -= (along[codes + 1] - along[codes]) / errors[:, None]

    def less_known(values: Floats) -> Floats:
        return np.asarray(values - known @ (known.T @ values))

    return less_known(slopes), less_known((counts[codes] - expected) / errors), known.shape[1]
