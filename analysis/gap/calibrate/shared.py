"""What blocks of a shot have in common: an offset of the frame, a part of its light, rows' offsets.

A black level that wanders, a lamp that flickers and rows with noise of their own move hundreds of
blocks at once. Were each of these called uncertain by itself, a determinant would count the same
hundreds of times. The difference d of a block b in row r of the shot s and the channel c from what
is expected is

    d_scb = own_scb + l_scr + k_c o_s + m_scb p_s

with the gain k in DN per e-, the signal m, and the offsets l of a row of blocks in DN, o of a frame
in e-, p of its light as a part. Least squares give o and p of each shot; the rest has l in its
means over rows. What these scatter beyond the errors that own differences leave them is theirs.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.ruler import Ruler
from analysis.gap.calibrate.space import Common, Space, common

Floats = NDArray[np.float64]

CLEAR = 4.0
"""Standard errors from which frames have an offset or a light of their own."""

SURE = 1.5
"""Times what chance makes of a variance from which rows have offsets of their own: chance knows of
normal differences, and spots are none."""

LEAST_OWN = 1e-3
"""Part of the errors of a space that blocks have of their own in any case."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Shared:
    """Variances of what blocks of a shot have in common, of one group of frames.

    Attributes:
        by: how it is read.
        rows_dn2: covariance between shots of the offset of a row of blocks, (channels, S, S).
        offset_e2: variance of the offset of a frame.
        light2: of its light, as a part.
    """

    by: Ruler
    rows_dn2: Floats
    offset_e2: float
    light2: float

    @property
    def frames(self) -> tuple[float, float]:
        """Variances of what all blocks of a shot have in common."""
        return self.offset_e2, self.light2

    def averaged(self, off: Floats) -> Shared:
        """What blocks have in common in the mean of several groups of frames.

        Args:
            off: the groups' differences from what is expected, (groups, S, channels, blocks). What
                of them is another one in each group is averaged, what all have stays.
        """
        groups = len(off)
        if groups < 2:
            return self
        apart = np.sqrt(groups / (groups - 1)) * (off - off.mean(axis=0))
        of_rows = self._rows_anew(apart)
        of_frames = self._frames_anew(apart, of_rows)
        once = 1.0 - 1.0 / groups
        offset_e2, light2 = (
            one * (1.0 - part * once) for one, part in zip(self.frames, of_frames, strict=True)
        )
        rows_dn2 = self.rows_dn2 * (1.0 - of_rows * once)
        return dataclasses.replace(self, rows_dn2=rows_dn2, offset_e2=offset_e2, light2=light2)

    def _rows_anew(self, apart: Floats) -> float:
        """Part of what rows have that is another one in each group.

        Args:
            apart: of each group from their mean, as wide as between two bodies.
        """
        by = self.by
        rows = by.rows(by.without_frames(apart))
        seen = np.einsum("nscr,nscr->sc", rows, rows) / (len(apart) * by.down)
        in_time = by.in_time_dn2.T[:, None, :, None] * np.eye(len(by.in_time_dn2))
        own = by.rows_error_dn2(np.broadcast_to(in_time, by.known.shape))
        whole = np.einsum("css->", self.rows_dn2)
        return _part(float(seen.sum() - np.einsum("css->", own)), float(whole))

    def _frames_anew(self, apart: Floats, of_rows: float) -> list[float]:
        """Parts of the variances of a frame's offset and of its light that are another one in each
        group.

        Args:
            apart: of each group from their mean, as wide as between two bodies.
            of_rows: part of what rows have that is another one in each group.
        """
        by = self.by
        own_dn2 = np.broadcast_to(by.in_time_dn2[..., None], by.own_dn2.shape)
        error = by.frames_error(own_dn2, of_rows * self.rows_dn2)
        squares = np.square(by.frames(apart)).mean(axis=0)
        return [
            _part(_weighed(squares[:, k], error[:, k], one)[0], one)
            for k, one in enumerate(self.frames)
        ]

    def taken_off(self, space: Space, twins: int) -> Space:
        """A space of blocks' own errors, with these as well.

        Args:
            space: in which blocks know nothing of each other.
            twins: of whose mean the expectation is.
        """
        both = 1.0 + 1.0 / twins
        if self.rows_dn2.any():
            space = dataclasses.replace(
                space, common=(_of_rows(space, both * self.rows_dn2, self.by.down),)
            )
        shots = space.shape[0]
        patterns = [
            np.sqrt(both * variance) * self.by.shapes[k] * np.eye(shots)[s][:, None, None]
            for k, variance in enumerate(self.frames)
            for s in range(shots)
            if variance > 0 and self.by.shapes[k, s].any()
        ]
        if not patterns:
            return space
        seen = np.array([space.blocks(pattern) for pattern in patterns])
        whole = common(np.arange(seen.shape[1])[None], seen.T[None])
        return dataclasses.replace(space, common=(*space.common, whole))

    def only(self, shots: list[int]) -> Shared:
        """What blocks have in common in some of the shots, by their places."""
        by = dataclasses.replace(
            self.by,
            shapes=self.by.shapes[:, shots],
            known=self.by.known[..., shots, :][..., shots],
            in_time_dn2=self.by.in_time_dn2[shots],
        )
        return dataclasses.replace(self, by=by, rows_dn2=self.rows_dn2[:, shots][..., shots])


def shared(by: Ruler, off: Floats) -> tuple[Shared | None, Floats]:
    """What blocks of twins have in common, None where nothing is clear, and what is left without.

    The errors that blocks leave to their means are read from what they scatter themselves: spots,
    which a space knows nothing of, make means of rows scatter as well and are in none in common.

    Args:
        by: how it is read.
        off: differences of twins from what is expected, (twins, S, channels, blocks), as wide as
            those of a capture.
    """
    count = len(off)
    rest = by.without_frames(off)
    rows = by.rows(rest)
    seen = np.einsum("nscr,ntcr->cst", rows, rows) / (count * by.down)
    each = rest.transpose(2, 3, 0, 1)
    # a shot whose codes are the same in all twins scatters by nothing
    least = LEAST_OWN * by.rows_error_dn2(by.known)
    by_chance = by.rows_error_dn2(each.swapaxes(-1, -2) @ each / count) + least
    rows_dn2 = _beyond(seen, by_chance, (count - 1) * (by.down - 1)) * by.for_the_mean
    error = by.frames_error(np.square(rest).mean(axis=0), rows_dn2)
    amounts = by.frames(off)
    offset_e2, light2 = (_variance(amounts[..., k], error[:, k]) for k in (0, 1))
    if not (rows_dn2.any() or offset_e2 or light2):
        return None, off
    found = Shared(by=by, rows_dn2=rows_dn2, offset_e2=offset_e2, light2=light2)
    return found, np.sqrt(by.for_the_mean) * (rest - by.of_blocks(rows)) if rows_dn2.any() else rest


def _of_rows(space: Space, rows_dn2: Floats, down: int) -> Common:
    """What rows of blocks have in common, of a covariance between shots (channels, S, S)."""
    shots, channels, blocks = space.shape
    values, vectors = np.linalg.eigh(rows_dn2)
    factor = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    white = space.whitening @ factor[:, None]  # (channels, blocks, S, k)
    across = blocks // down
    seen = white.reshape(channels * down, across, shots, shots).transpose(0, 2, 1, 3)
    places = np.arange(shots * channels * blocks).reshape(shots, channels, down, across)
    members = places.transpose(1, 2, 0, 3).reshape(channels * down, shots * across)
    return common(members, seen.reshape(channels * down, shots * across, shots))


def _beyond(seen: Floats, known: Floats, count: int) -> Floats:
    """A covariance beyond one that is known, (..., S, S): what is more than chance of so many."""
    root = np.linalg.cholesky(known)
    white = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(white @ seen @ white.swapaxes(-1, -2))
    chance = (1.0 + np.sqrt(seen.shape[-1] / max(count, 1))) ** 2
    more = np.where(values > SURE * chance, values - 1.0, 0.0)
    factor = root @ (vectors * np.sqrt(more)[..., None, :])
    return np.asarray(factor @ factor.swapaxes(-1, -2))


def _variance(amounts: Floats, error: Floats) -> float:
    """The variance that amounts (twins, S) have beyond a known one of each shot, (S,).

    What all shots have in common calibration takes up. 0 where nothing is clear.
    """
    shown = error > 0
    shots = np.count_nonzero(shown)
    if shots < 2:
        return 0.0
    apart, known = amounts[:, shown], error[shown]
    apart = apart - (apart / known).sum(axis=1, keepdims=True) / (1.0 / known).sum()
    squares = np.square(apart).mean(axis=0) * shots / (shots - 1)
    first, chance = _weighed(squares, known, 0.0)
    if first < CLEAR * chance / np.sqrt(len(amounts)):
        return 0.0
    return max(_weighed(squares, known, first)[0], 0.0)


def _weighed(squares: Floats, error: Floats, variance: float) -> tuple[float, float]:
    """A variance beyond errors (S,), from mean squares weighed as if it were `variance`; its own
    error from one square of each.
    """
    shown = error > 0
    if not shown.any():
        return 0.0, np.inf
    weight = np.square(1.0 / (error[shown] + variance))
    return (
        float(weight @ (squares[shown] - error[shown]) / weight.sum()),
        float(np.sqrt(2.0 / weight.sum())),
    )


def _part(of: float, whole: float) -> float:
    return float(np.clip(of / whole, 0.0, 1.0)) if whole > 0 else 0.0
