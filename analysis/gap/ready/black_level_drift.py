"""How far the black level wanders from frame to frame and from row to row, and how soon it forgets.

What all samples of a dark frame share is its mean, and what those of a row share is that of the
row. Means of a walk that is pulled back, with noise on top that forgets at once, are normal, and
those that are l apart have the covariance

    C(l) = s^2 exp(-l / L) + w^2 [l = 0]

Whatever else a mean may have in it says nothing of the walk and is taken off: of rows the level of
their frame, of frames a black level and a dark current that all shots share. The likelihood of
what is left needs the eigenvalues of the first term alone, for any w; s has its best value for each
L and w, and all three are summed over, as nobody knows a factor of any of them beforehand.

A camera that was calibrated to such frames has both walks in its clamp, and that of frames in its
light, as each shot found another black level. So it begins where moments put it, with a clamp that
is quiet.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from analysis.bias.rounding import rounded
from analysis.gap.calibrate.darks import NODES, WEIGHTS
from analysis.gap.camera.base import Base
from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting
from sensor.frames import Frames

Floats = NDArray[np.float64]

FEWEST_FRAMES = 12
"""Of a dark that is asked."""

CLEAR = 5.0
"""Standard errors by which means of neighbours are nearer than those of white noise."""

LONGEST = 4.0
"""Series that a walk remembers at most: of a longer one they tell s^2 / L alone."""

TRIED = 40
"""Lengths, and ratios of w^2 to s^2, each from one end of what is possible to the other, and once
more where they are likely."""

RATIOS = (1e-4, 1e4)
"""Between which ratios of w^2 to s^2 are tried."""

UNLIKELY = 12.0
"""Logarithm of a likelihood over the largest, below which none is looked at again."""

NEIGHBOURS = 6.0
"""Rows that a walk remembers at least: what filters a picture mixes fewer."""

MOST_FIGURES = 256
"""Of a series that are held against each other: a covariance of them is decomposed for each length.
Rows beyond begin another series, and frames beyond are left out."""

STEP_DN = 0.05
"""Of a black level, by which the response to it is told."""

LEAST_RESPONSE = 0.5
"""Of a mean to its black level, below which rounding and clipping hide too much of a walk."""


@dataclass(frozen=True, kw_only=True)
class Walk:
    """A walk that is pulled back, as series of it tell.

    Attributes:
        sigma, length: standard deviation, and steps in which all but 1/e is forgotten.
        sigma_error, length_error: their standard errors.
    """

    sigma: float
    length: float
    sigma_error: float
    length_error: float


def wandering(setting: Setting) -> DirectReading | None:
    """Spread and length of the walks of black; None where dark frames do not wander.

    Args:
        setting: the capture.
    """
    darks = setting.darks(FEWEST_FRAMES)
    if not darks:
        return None
    _, base = by_moments(setting)
    responses = [response_of(base, stack) for stack in darks]
    if min(responses) < LEAST_RESPONSE:
        return None
    lattices = setting.scenery.view.lattices
    rows = [
        _rows_dn(stack, lattices) / (response * float(base.gain_dn_per_e[_green(base)]))
        for stack, response in zip(darks, responses, strict=True)
    ]
    hints, errors = _down_the_rows(rows)
    frames = [one.mean(axis=1) for one in rows]
    if not hints and not wanders([one[None] for one in frames]):
        return None
    # a shot forgets a long walk too seldom to tell it by itself; where rows walk, frames may
    along = along_the_shots(frames, [stack.shot.exposure_s for stack in darks])
    hints = {
        "row_sigma_e": 0.0,
        **hints,
        "frame_sigma_e": along.sigma,
        "frame_length": along.length,
    }
    errors = {**errors, "frame_sigma_e": along.sigma_error, "frame_length": along.length_error}
    fitted = DirectReading(hints=hints, exact=False, base=dataclasses.replace(base, clamp_e2=0.0))
    return DirectReading(hints=hints, errors=errors, instead=fitted)


def _green(base: Base) -> int:
    """Place of green, which no white balance multiplies, or of grey."""
    return base.channels.index("G") if "G" in base.channels else 0


def _rows_dn(stack: Frames, lattices: Sequence[Lattice]) -> Floats:
    """Means of the rows of each frame, (F, h), of green samples that were measured, or grey ones.

    A mosaic has a green in every other column of each row.
    """
    asked = [one for one in lattices if one.channel in "GY"]
    in_turn = [one.of(stack.dn).mean(axis=2) for one in sorted(asked, key=lambda one: one.dy)]
    return np.stack(in_turn, axis=2).reshape(stack.count, -1)


def response_of(base: Base, dark: Frames) -> float:
    """By how much the mean of a dark follows its black level, behind rounding and clipping.

    Args:
        base: the camera by moments.
        dark: one of its shots.
    """
    place, exposure_s, top_dn = _green(base), dark.shot.exposure_s, dark.top_dn
    gain = float(base.gain_dn_per_e[place])
    black_dn = float(base.black_dn[place]) + gain * base.shown_e_per_s * exposure_s
    noise_dn2 = float(base.read_dn2[place]) + gain**2 * base.dark_e_per_s * exposure_s
    pattern_dn2 = float(base.fpn_dn2[place]) + gain**2 * base.dark_spread2 * exposure_s**2
    pixels_dn = black_dn + NODES * np.sqrt(pattern_dn2)
    low, high = (
        WEIGHTS @ rounded(pixels_dn + by, np.sqrt(noise_dn2), top_dn).mean_dn
        for by in (-STEP_DN, STEP_DN)
    )
    return float(high - low) / (2.0 * STEP_DN)


def _down_the_rows(rows: Sequence[Floats]) -> tuple[dict[str, float], dict[str, float]]:
    """The walk down the rows and its errors, by their means in each shot; none if they do not.

    Args:
        rows: the means, (F, h) of each shot.
    """
    # what frames of a shot share is the body's, and two rows may be of other colours
    moving = [one - one.mean(axis=0) for one in rows]
    if not any(wanders([one[:, dy::2] for one in moving]) for dy in (0, 1)):
        return {}, {}
    height = rows[0].shape[1]
    pieces = -(-height // MOST_FIGURES)
    count = height // pieces
    found = walk(
        np.concatenate(moving)[:, : pieces * count].reshape(-1, count),
        _apart(count),
        np.ones((count, 1)),
        longest=LONGEST * count,
        lost=pieces * len(rows),
    )
    if found.length < NEIGHBOURS:
        return {}, {}
    return (
        {"row_sigma_e": found.sigma, "row_length": found.length},
        {"row_sigma_e": found.sigma_error, "row_length": found.length_error},
    )


def wanders(means: Sequence[Floats]) -> bool:
    """Whether neighbours are nearer than chance makes them: of n figures of white noise, squares
    of steps over squares of deviations have an expectation of 2 and a standard error of 2 / sqrt n.

    Args:
        means: of the frames of each shot, or of the rows of its frames: (series, figures) each.
    """
    steps = sum(float(np.square(np.diff(one)).sum()) for one in means)
    spread = sum(float(np.square(one - one.mean(axis=1, keepdims=True)).sum()) for one in means)
    count = sum(one.size for one in means)
    return spread > 0 and steps / spread < 2.0 - CLEAR * 2.0 / np.sqrt(count)


def along_the_shots(frames: Sequence[Floats], exposures_s: Sequence[float]) -> Walk:
    """The walk from frame to frame, by their means in each shot.

    Args:
        frames: the means, (F,) of each shot.
        exposures_s: of the shots.
    """
    most = max(MOST_FIGURES // len(frames), FEWEST_FRAMES)
    frames = [one[:most] for one in frames]
    counts = [len(one) for one in frames]
    apart = linalg.block_diag(*(_apart(count) + 1.0 for count in counts)) - 1.0
    exposure_s = np.repeat(exposures_s, counts)
    return walk(
        np.concatenate(frames)[None],
        np.where(apart < 0.0, np.inf, apart),
        np.column_stack([np.ones(len(exposure_s)), exposure_s]),
        longest=LONGEST * max(counts),
    )


def _apart(count: int) -> Floats:
    """Steps between any two of a series, (count, count)."""
    return np.abs(np.subtract.outer(np.arange(count), np.arange(count))).astype(np.float64)


def walk(means: Floats, apart: Floats, other: Floats, *, longest: float, lost: int = 0) -> Walk:
    """The walk that series of means tell.

    Args:
        means: (series, figures).
        apart: steps between any two figures, (figures, figures); infinite where one forgets all of
            the other.
        other: what else each series may have in it, (figures, ways).
        longest: steps after which a walk forgets at most.
        lost: series that went into what was taken off before.
    """
    moving = linalg.null_space(other.T)
    squares = moving.T @ (means.T @ means) @ moving
    series = len(means) - lost
    lengths, ratios = np.geomspace(1.0, longest, TRIED), np.geomspace(*RATIOS, TRIED)
    for _ in range(2):
        likely, sigma2 = _likely(squares, series, moving, apart, lengths, ratios)
        weight, at = np.exp(likely - likely.max()), (lengths, ratios)
        possible = likely > likely.max() - UNLIKELY
        lengths, ratios = (_between(one, possible.any(axis=1 - k)) for k, one in enumerate(at))
    more = 0.5 / (series * len(squares))
    sigma, sigma_error = _of_a_logarithm(np.log(sigma2) / 2.0, weight, more)
    length, length_error = _of_a_logarithm(np.log(at[0])[:, None], weight)
    return Walk(sigma=sigma, length=length, sigma_error=sigma_error, length_error=length_error)


def _likely(
    squares: Floats,
    series: int,
    moving: Floats,
    apart: Floats,
    lengths: Floats,
    ratios: Floats,
) -> tuple[Floats, Floats]:
    """Logarithm of the likelihood with any spread, and the likeliest s^2, (lengths, ratios).

    Args:
        squares: of all series, summed, along each way in which they may move.
        series: their number.
        moving: these ways, (figures, ways).
        apart, lengths, ratios: see `walk`.
    """
    log_det, chi2 = np.zeros((2, len(lengths), len(ratios)))
    for k, length in enumerate(lengths):
        values, ways = np.linalg.eigh(moving.T @ np.exp(-apart / length) @ moving)
        along = np.einsum("ij,ij->j", ways, squares @ ways)
        variances = values[:, None] + ratios
        log_det[k] = series * np.log(variances).sum(axis=0)
        chi2[k] = (along[:, None] / variances).sum(axis=0)
    figures = series * len(squares)
    return -(log_det + figures * np.log(chi2)) / 2.0, chi2 / figures


def _between(tried: Floats, possible: NDArray[np.bool_]) -> Floats:
    """As many from the one before the first that is possible to the one after the last."""
    at = np.flatnonzero(possible)
    first, last = max(at[0] - 1, 0), min(at[-1] + 1, len(tried) - 1)
    return np.geomspace(tried[first], tried[last], TRIED)


def _of_a_logarithm(values: Floats, weight: Floats, more: float = 0.0) -> tuple[float, float]:
    """What a logarithm is the mean of, and its standard error.

    Args:
        values, weight: of the logarithm, and how likely each is.
        more: variance of the logarithm besides.
    """
    whole = float(weight.sum())
    middle = float((weight * values).sum()) / whole
    variance = float((weight * np.square(values - middle)).sum()) / whole + more
    return float(np.exp(middle)), float(np.exp(middle) * np.sqrt(variance))
