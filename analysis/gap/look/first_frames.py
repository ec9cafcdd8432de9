"""First frames of a shot that are not like the rest.

A photosite that keeps a share f of its charge gives a first frame too little, or what was left of
the shot before. Of a step of light A that is missing

    f A in the first frame, f^2 A in the second, f^(k+1) A in frame k,

with A the whole signal where a shot begins in the dark, and its difference from the shot before
where shots follow each other. Where each electron stays by chance this is all that there is to see:
what is left of a Poisson process is one, and frames of steady light are as independent as before.

Statistics are of groups of frames, and twins of a shot's steady part. So these frames are left out
of them, and speak for themselves.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from sensor.frames import Capture, Frames

Floats = NDArray[np.float64]

LEFT_OUT = 4
"""Frames at the beginning of every shot that are left out: of a share of a tenth 1e-4 is left."""

FEWEST = 3 * LEFT_OUT
"""Frames of a shot that tell it; up to `MOST` are looked at."""

MOST = 32
"""Frames of a shot that are looked at."""

ENOUGH_PX = 20_000
"""Of larger frames every other pixel is looked at, or fewer: about so many."""

STANDS_OUT = 10.0
"""Scatters of the later frames' means by which the first one's differs."""

OVER = 0.2
"""Part of what the first frame is off by that the second is off by at most: what stays behind is a
tenth, and a lamp that warms up in three frames is off by 0.7."""

ALIKE = 0.1
"""Part of what first frames are off by that one share for all shots leaves at most."""

SURE = 4.0
"""Standard errors within which the second frame is off by the share of the share."""


@dataclass(frozen=True, kw_only=True)
class Beginning:
    """How the shots of a capture begin.

    Attributes:
        shots: labels of the lit shots that begin unlike the rest of their frames.
        off_dn: by how much the mean of the first frame of each differs, in DN.
        z: the same in scatters of the frames' means.
        chance: that the largest of them comes about by chance.
        share, share_se: of the charge that stays behind, if that is what it is.
        from_dark: whether shots begin in the dark, and not with what the one before has left.
    """

    shots: tuple[str, ...]
    off_dn: tuple[float, ...]
    z: tuple[float, ...]
    chance: float
    share: float | None
    share_se: float | None
    from_dark: bool = True


@dataclass(frozen=True, kw_only=True, eq=False)
class _Means:
    """Means of the frames of a shot in DN: of the first two less the mean of the later ones, that
    mean, and the scatter of one frame.
    """

    label: str
    lit: bool
    off: Floats
    level: float
    scatter: float

    @property
    def begins_otherwise(self) -> bool:
        """Whether the first frame is off, and the second is not."""
        first, second = np.abs(self.off)
        return bool(first > STANDS_OUT * self.scatter and second < OVER * first)


def beginning(capture: Capture) -> Beginning | None:
    """How shots begin, where most of those that are lit begin unlike the rest, and are like it from
    the second frame on; else None.
    """
    shots = [_means_of(f) for f in capture.frames if f.count >= FEWEST]
    lit = [one for one in shots if one.lit]
    off = [one for one in lit if one.begins_otherwise]
    if 2 * len(off) <= len(lit):
        return None
    z = np.array([one.off[0] / max(one.scatter, 1e-9) for one in off])
    freedom = min(min(f.count, MOST) for f in capture.lit if f.count >= FEWEST) - LEFT_OUT - 1
    share, share_se, from_dark = _share(shots) or (None, None, True)
    return Beginning(
        shots=tuple(one.label for one in off),
        off_dn=tuple(float(one.off[0]) for one in off),
        z=tuple(map(float, z)),
        chance=min(1.0, len(lit) * 2.0 * float(stats.t.sf(np.abs(z).max(), freedom))),
        share=share,
        share_se=share_se,
        from_dark=from_dark,
    )


def without_beginnings(capture: Capture) -> Capture:
    """The capture without the first frames of its shots."""
    frames = (
        dataclasses.replace(f, dn=f.dn[LEFT_OUT:]) if f.count >= FEWEST else f
        for f in capture.frames
    )
    return dataclasses.replace(capture, frames=tuple(frames))


def _means_of(frames: Frames) -> _Means:
    step = max(1, round((frames.height * frames.width / ENOUGH_PX) ** 0.5))
    few = frames.dn[:MOST, ::step, ::step]
    means = few.reshape(len(few), -1).mean(axis=1, dtype=np.float64)
    later = means[LEFT_OUT:]
    return _Means(
        label=frames.shot.label,
        lit=not frames.shot.dark,
        off=means[:2] - later.mean(),
        level=float(later.mean()),
        scatter=float(later.std(ddof=1)),
    )


def _share(shots: Sequence[_Means]) -> tuple[float, float, bool] | None:
    """The share that stays behind, its standard error, and whether shots begin in the dark: by the
    first frames of all shots, if the second frames bear it out; None if it is no such thing.

    Args:
        shots: in the order in which they were taken.
    """
    levels = np.array([one.level for one in shots])
    ways = {False: np.diff(levels, prepend=levels[0])}
    if dark := [one.level for one in shots if not one.lit]:
        ways[True] = levels - min(dark)  # without a dark nothing tells how bright shots are
    first, second = np.array([one.off for one in shots]).T
    noise = np.array([one.scatter for one in shots])
    found = []
    for from_dark, steps in ways.items():
        length = float(steps @ steps)
        if not length:
            continue
        share = -float(first @ steps) / length
        left = first + share * steps
        error = float(np.sqrt(np.square(noise * steps).sum())) / length
        in_second = -float(second @ steps) / length
        borne_out = abs(in_second - share**2) < max(SURE * error, share**2 / 2)
        if share > SURE * error and borne_out:
            found.append((float(left @ left) / float(first @ first), share, error, from_dark))
    if not found or min(found)[0] > ALIKE**2:
        return None
    _, share, error, from_dark = min(found)
    return share, error, from_dark
