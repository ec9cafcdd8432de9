"""Standard errors of figures of noise, by what twins of one camera show of them."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.look.families import EVERY_SHOT, INTERPOLATION, NEIGHBOURS
from analysis.gap.look.kinds import kinds
from analysis.gap.look.observation import Key, Observation

Floats = NDArray[np.float64]

PRIOR_FREEDOM = 8.0
"""Degrees of freedom that a variance borrows from the same statistic in other places."""

LEAST_SPREAD = 1e-6
"""Of a figure that never moved in any twin."""

ROOTS_OF_SHARES = frozenset(
    {"loud pixels", "hot samples", "very hot samples", "at zero", "at the top"}
)
"""Figures that are roots of a share of samples: a count of n has a root with the error 1/2."""

ROOT_OF_A_SHARE_OF_BLOCKS = "residual outliers"

OF_THE_PICTURE = ("codes", "texture", "grid of 8", "off bilinear", "variance, part")
"""Beginnings of the names of families and statistics that depend on the picture to its last detail:
of lit shots whose light was read from the frames they tell nothing."""

OF_NOISE = frozenset(
    {"rows", "columns", "frames", NEIGHBOURS, "time", "tails", "spectrum", "pattern lines",
     "pattern shape", "dark surface", INTERPOLATION}
)  # fmt: skip
"""Families that tell how noise is shared out among pixels, places and frames, not how much there
is."""

FEW_CHANGES = 100.0
"""Variance in time of all samples of a group of frames together, in DN^2, below which so few of
them change their code that chance shares them out: one pixel with another code in one frame of a
dark makes every such figure, and in most twins there is none."""

NOTHING = 1e4
"""Standard errors become so many times larger where a figure tells nothing."""


def figure_variances(twins: Observation, known: bool = True) -> Floats:
    """Variance of each figure of one group between twins, drawn to that of its like elsewhere.

    Args:
        twins: of one base; each group is another body.
        known: whether the light is known.
    """
    keys, figures = twins.keys, twins.figures
    freedom = len(figures) - 1
    least = np.full(len(keys), LEAST_SPREAD**2)
    blocks = twins.means.shape[-1]
    least[[key.statistic in ROOTS_OF_SHARES for key in keys]] = 0.25 / (twins.samples * blocks)
    least[[key.statistic == ROOT_OF_A_SHARE_OF_BLOCKS for key in keys]] = 0.25 / blocks
    own = np.maximum(figures.var(axis=0, ddof=1), least)
    pooled = own.copy()
    for places in kinds(keys, twins.lit):
        pooled[places] = np.exp(np.mean(np.log(own[places])))
    variances = (freedom * own + PRIOR_FREEDOM * pooled) / (freedom + PRIOR_FREEDOM)
    silent = _of_few_changes(twins)
    if not known:
        silent |= np.array([
            key.shot in twins.lit
            and (key.family.startswith(OF_THE_PICTURE) or key.statistic.startswith(OF_THE_PICTURE))
            for key in keys
        ])  # fmt: skip
    variances[silent] *= NOTHING**2
    return np.asarray(variances)


def _of_few_changes(twins: Observation) -> NDArray[np.bool_]:
    """Which figures tell how noise is shared out where there is next to none, (figures,)."""
    in_all = twins.noise * twins.samples * twins.means.shape[-1] * twins.frames
    few = dict(zip(twins.shots, in_all < FEW_CHANGES, strict=True))
    places = {channel: place for place, channel in enumerate(twins.channels)}

    def tells_nothing(key: Key) -> bool:
        told = key.family in OF_NOISE and key.statistic not in ROOTS_OF_SHARES
        if not told or key.shot not in few:
            return False
        place = places.get(key.lattice[0])  # None: of all channels together
        return bool(few[key.shot].all() if place is None else few[key.shot][place])

    return np.array([tells_nothing(key) for key in twins.keys])


CHANGING_DN2 = 1e-3
"""Variance in time from which some pixels of every frame have another code in the next one: one in
a thousand by a step."""

BEYOND_DOUBT = 16.0
"""Standard errors that a frame counts which repeats the one before, where every frame has noise.
Spreads are read from a few twins, so that 8 of them count as 5, which are lost among a hundred
figures of time; these are not."""


def never_moved(twins: Observation, seen: Observation) -> Floats:
    """Standard errors of figures that are the same in all twins, (figures,); 0 for the others.

    Where a code changes once in a hundred frames a figure may be 0 in every twin and not in the
    capture, and nobody knows how far it goes. Groups of frames are alike where nothing is wrong, so
    that k of the n + g that move are all among the g of the capture with a chance of

        C(g, k) / C(n + g, k)

    and the difference counts as many standard errors as a normal one of that chance. Frames with
    noise in time never repeat each other by chance, nor rows of them: there k repeats are
    BEYOND_DOUBT sqrt(k) standard errors from none.

    Args:
        twins: groups of the model.
        seen: groups of the capture, with the same keys.
    """
    still = np.ptp(twins.figures, axis=0) == 0
    moved = np.count_nonzero(seen.figures != twins.figures[0], axis=0)
    n, g = twins.groups, seen.groups
    chances = np.array([comb(g, k) / comb(n + g, k) for k in range(g + 1)])
    counts = stats.norm.isf(chances / 2)[moved]
    off = np.abs(seen.figures.mean(axis=0) - twins.figures[0])
    errors = np.where(still & (moved > 0), off / np.maximum(counts, 1e-9), 0.0)
    if twins.noise.max(axis=1).min() > CHANGING_DN2:
        repeated = np.array([key.shot == EVERY_SHOT for key in twins.keys])
        of_repeats = np.sqrt(np.maximum(off * seen.counted, 1.0)) / (BEYOND_DOUBT * seen.counted)
        errors = np.where(repeated & still, of_repeats, errors)
    return np.asarray(errors)
