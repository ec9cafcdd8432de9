"""Combs: what curves behind the converter leave in the codes.

Whole codes that are multiplied or bent, and rounded again, leave out some codes and take others
twice. Noise and light make histograms smooth, so that nothing else has such teeth, and each curve
has its own: a gain of 1.2 leaves out every sixth code. `whole_gains` and `curve` read what each of
them was.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from analysis.gap.look.lattices import Lattice

Floats = NDArray[np.float64]

FRAMES = 16
"""Frames of a shot whose codes are counted."""

MOST_CODES = 256
"""Finer codes than these hardly show whether they were rounded twice."""

WINDOW = 15
"""Codes over which a histogram is smooth; a comb has several teeth in them."""

BESIDE = 5
"""Codes whose median is what one of them has but for a tooth, where teeth are few."""

LEAST_COUNT = 40
"""Samples of a code that make its count worth a look."""

LEAST_CODES = 30
"""Such codes that a histogram must have for its teeth to be read."""

SLACK = 0.02
"""By how much less a comb may be like the histogram and still fit as well."""

NEAR = 0.03
"""A gain or an exponent nearer to 1 than this has too few teeth."""

OF_FEW_TEETH = 0.4
"""Part of what is uneven that a comb of few teeth explains. None of 12 cameras had any without a
curve, nor with a white balance of 1.02; one with unequal steps had 0.46."""

MANY_ORIGINS = np.arange(-0.6, 0.61, 0.05)
"""Where black may be, from a first black level, where a few teeth are all there is."""

GAINS = np.round(np.arange(0.67, 2.0, 5e-4), 4)
"""Gains that are tried where nothing tells them roughly."""


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


Teeth = tuple[NDArray[np.intp], Floats]
"""Codes away from the ends of a histogram, and how much they differ from their surroundings."""


def teeth_of(counts: Floats) -> Teeth | None:
    """What is uneven in a histogram, (codes,); None where it has too few codes to tell."""
    smooth = ndimage.uniform_filter1d(counts, WINDOW, mode="constant")
    # the ends have slopes of their own
    at = np.flatnonzero(ndimage.minimum_filter1d(smooth, WINDOW) > LEAST_COUNT)
    if len(at) < LEAST_CODES:
        return None
    seen = counts[at] / smooth[at]
    return at, np.clip(seen - seen.mean(), -1.0, 1.0)


def few_teeth_of(counts: Sequence[Floats]) -> Teeth | None:
    """What is uneven in the histograms of all channels alike, (codes,): teeth that are far apart.

    Each code is held against those beside it, so that patches of a chart have none; the median of
    the channels counts. None where there are too few codes to tell.

    Args:
        counts: histograms, (top_dn + 1,) each.
    """
    beside = ndimage.median_filter(np.array(counts), (1, BESIDE), mode="constant")
    at = np.flatnonzero(ndimage.minimum_filter1d(beside.min(axis=0), WINDOW) > LEAST_COUNT)
    if len(at) < LEAST_CODES:
        return None
    seen = np.median(np.array(counts)[:, at] / beside[:, at], axis=0)
    return at, np.clip(seen - 1.0, -1.0, 1.0)


def combs(curves: Floats, size: int) -> Floats:
    """How often each code is hit, over how often those around it are, (size, n).

    Args:
        curves: what becomes of each whole code, (codes, n).
        size: number of codes; what is beyond is clipped.
    """
    count = curves.shape[1]
    places = np.clip(np.rint(curves), 0, size - 1).astype(np.int64) + size * np.arange(count)
    hits = np.bincount(places.ravel(), minlength=size * count).reshape(count, size).T
    around = ndimage.uniform_filter1d(hits.astype(np.float64), WINDOW, axis=0)
    return np.asarray(hits / np.maximum(around, 1e-9))


def fitting(teeth: Teeth, figures: Floats, of_figures: Floats, near: float) -> tuple[float, float]:
    """The figure whose comb is most like a histogram: how much, and which.

    Args:
        teeth: of the histogram.
        figures: one for each comb, (n,).
        of_figures: the combs, (codes, n).
        near: figures that are nearer to 1 are out of the question.
    """
    at, seen = teeth
    comb = of_figures[at] - of_figures[at].mean(axis=0)
    norm = np.sqrt(np.square(comb).sum(axis=0) * np.square(seen).sum())
    likeness = np.where(np.abs(figures - 1) >= near, seen @ comb / np.maximum(norm, 1e-9), 0.0)
    return float(likeness.max()), _roundest(figures[likeness > likeness.max() - SLACK])


def like_few(teeth: Teeth, figures: Floats, of_figures: Floats) -> tuple[float, float]:
    """The figure whose comb explains most of a few teeth: which part of them, and which.

    Args:
        teeth: of `few_teeth_of`.
        figures: one for each comb, (n,).
        of_figures: the combs, (codes, n).
    """
    told = explained(teeth, of_figures)
    return float(told.max()), float(np.median(figures[told > told.max() - SLACK]))


def explained(teeth: Teeth, of_figures: Floats, off: float = 0.5) -> Floats:
    """Which part of a few teeth each comb explains, (n,): 0 where there are none.

    Args:
        teeth: of `few_teeth_of`.
        of_figures: the combs, (codes, n).
        off: how right a tooth is that is a code off.
    """
    at, seen = teeth[0], _nearby(teeth[1], off)
    comb = _nearby(np.clip(of_figures[at] - 1.0, -1.0, 1.0), off)
    of_all = np.square(seen).sum()
    told = 2.0 * seen @ comb - np.square(comb).sum(axis=0)
    return np.asarray(told / of_all if of_all else np.zeros_like(told))


def _nearby(teeth: Floats, off: float) -> Floats:
    """Teeth that reach into the codes beside them."""
    return np.asarray(ndimage.convolve1d(teeth, [off, 1.0, off], axis=0, mode="constant"))


def _roundest(alike: Floats) -> float:
    """Of figures that fit alike, the one with fewest decimals: people set them."""
    return float(min(alike, key=lambda figure: (len(f"{figure:g}"), abs(figure - alike.mean()))))
