"""How far the black level wanders from frame to frame and from row to row, and how soon it forgets.

What all samples of a dark frame share is its mean, and what those of a row share is that of the
row. Half the mean square of what means differ by that are l apart is, of a walk that is pulled back
and of noise that forgets at once,

    D(l) = s^2 (1 - exp(-l / L)) + w^2

A camera that was calibrated to such frames has both walks in its clamp, and that of frames in its
light, as each shot found another black level. So it begins where moments put it, with a clamp that
is quiet.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from analysis.gap.ready.hints import Told
from analysis.gap.ready.moments import by_channel, by_moments
from analysis.gap.ready.setting import Setting

Floats = NDArray[np.float64]

FEWEST_FRAMES = 12
"""Of a dark that is asked."""

CLEAR = 5.0
"""Standard errors by which means of neighbours are nearer than those of white noise."""

PART_OF_A_SHOT = 0.5
"""Largest lag over the frames, beyond which few pairs are left; and longest length of a walk: of a
longer one a shot tells s^2 / L alone."""

LENGTHS = 30
"""That are tried, from one frame on."""

NEIGHBOURS = 3.0
"""Rows of a lattice that a walk remembers at least: what filters a picture mixes fewer."""


def wandering(setting: Setting) -> Told | None:
    """Spread and length of the walks of black; None where dark frames do not wander.

    Args:
        setting: the capture.
    """
    darks = setting.darks(FEWEST_FRAMES)
    if not darks:
        return None
    _, base = by_moments(setting)
    gain = by_channel(base)
    lattices = setting.scenery.view.lattices
    of_rows = [
        [(one.of(stack.dn) / gain[one.channel]).mean(axis=2) for one in lattices] for stack in darks
    ]
    rows = _down_the_rows(of_rows, lattices[0].step)
    frames = [np.mean([one.mean(axis=1) for one in shot], axis=0) for shot in of_rows]
    if not rows and not wanders(frames):
        return None
    # a shot forgets a long walk too seldom to tell it by itself; where rows walk, frames may
    frame_sigma_e, frame_length = walk(frames)
    hints = {
        "row_sigma_e": 0.0,
        **rows,
        "frame_sigma_e": frame_sigma_e,
        "frame_length": frame_length,
    }
    return Told(hints=hints, exact=False, base=dataclasses.replace(base, clamp_e2=0.0))


def _down_the_rows(of_rows: Sequence[Sequence[Floats]], step: int) -> dict[str, float]:
    """The walk down the rows, by their means (F, h) in each shot and lattice; none if they do not.

    Args:
        of_rows: the means.
        step: rows of the picture from one to the next.
    """
    traces = [trace for shot in of_rows for rows in shot for trace in _of_a_frame(rows)]
    if not wanders(traces):
        return {}
    sigma_e, length = walk(traces)
    return {"row_sigma_e": sigma_e, "row_length": step * length} if length >= NEIGHBOURS else {}


def _of_a_frame(rows: Floats) -> Floats:
    """What each of F frames has beyond what all of them share, as loud as if nothing were lost."""
    frames = len(rows)
    return np.asarray((rows - rows.mean(axis=0)) * np.sqrt(frames / (frames - 1)))


def wanders(means: Sequence[Floats]) -> bool:
    """Whether neighbours are nearer than chance makes them: of n figures of white noise, squares
    of steps over squares of deviations have an expectation of 2 and a standard error of 2 / sqrt n.

    Args:
        means: of the frames of each shot, or of the rows of each frame.
    """
    steps = sum(float(np.square(np.diff(one)).sum()) for one in means)
    spread = sum(float(np.square(one - one.mean()).sum()) for one in means)
    count = sum(len(one) for one in means)
    return spread > 0 and steps / spread < 2.0 - CLEAR * 2.0 / np.sqrt(count)


def walk(means: Sequence[Floats]) -> tuple[float, float]:
    """Standard deviation and length of the walk, by what means differ by at each lag.

    Args:
        means: of the frames of each shot, or of the rows of each frame, in electrons.
    """
    most = int(PART_OF_A_SHOT * min(len(one) for one in means))
    lags = np.arange(1, most + 1)
    apart = [
        np.mean(np.concatenate([np.square(one[lag:] - one[:-lag]) for one in means])) / 2.0
        for lag in lags
    ]
    # of a walk larger differences are as much less certain
    weight = 1.0 / np.maximum(np.array(apart), 1e-12)
    fits = []
    for length in np.geomspace(1.0, most, LENGTHS):
        columns = np.column_stack([1.0 - np.exp(-lags / length), np.ones(len(lags))])
        amounts, left = nnls(columns * weight[:, None], np.ones(len(lags)))
        fits.append((left, float(np.sqrt(amounts[0])), float(length)))
    _, sigma, length = min(fits)
    return sigma, length
