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

from analysis.gap.calibrate.space import Common, Space, common
from analysis.gap.camera.base import Base
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]

CLEAR = 4.0
"""Standard errors from which frames have an offset or a light of their own."""

SURE = 1.5
"""Times what chance makes of a variance from which rows have offsets of their own: chance knows of
normal differences, and spots are none."""


LEAST_OWN = 1e-3
"""Part of the errors of a space that blocks have of their own in any case."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ruler:
    """Least squares for what blocks have in common.

    Attributes:
        shapes: what an offset and a part of the light make of a block, (2, S, channels, blocks).
        known: covariance between shots of one group of frames of twins, (channels, blocks, S, S).
        in_time_dn2: the part of it that is noise in time, (S, channels).
        down: rows of blocks.
    """

    shapes: Floats
    known: Floats
    in_time_dn2: Floats
    down: int

    @property
    def own_dn2(self) -> Floats:
        """Variance of each block, (S, channels, blocks)."""
        return np.asarray(np.diagonal(self.known, axis1=-2, axis2=-1).transpose(2, 0, 1))

    @property
    def weight(self) -> Floats:
        """Of each block, (S, channels, blocks)."""
        return 1.0 / self.own_dn2

    def by_row(self, of_blocks: Floats) -> Floats:
        """(..., blocks) as (..., down, across)."""
        return of_blocks.reshape(*of_blocks.shape[:-1], self.down, -1)

    @property
    def inverse(self) -> Floats:
        """Inverse of the normal equations of each shot, (S, 2, 2); 0 of what it does not show."""
        normal = np.einsum("iscb,jscb,scb->sij", self.shapes, self.shapes, self.weight)
        scale = np.sqrt(np.diagonal(normal, axis1=1, axis2=2))
        scale = np.where(scale > 0, scale, np.inf)
        product = scale[:, :, None] * scale[:, None, :]
        alike = np.where(np.isfinite(product), normal / product, 0.0)
        return np.asarray(np.linalg.pinv(alike, rcond=1e-6, hermitian=True) / product)

    def frames(self, off: Floats) -> Floats:
        """Offset in e- and part of the light of each shot, (n, S, 2), of (n, S, C, blocks)."""
        right = np.einsum("iscb,scb,nscb->nsi", self.shapes, self.weight, off)
        return np.asarray(np.einsum("sij,nsj->nsi", self.inverse, right))

    def without_frames(self, off: Floats) -> Floats:
        """What these leave of differences."""
        return np.asarray(off - np.einsum("iscb,nsi->nscb", self.shapes, self.frames(off)))

    def rows(self, rest: Floats) -> Floats:
        """Weighted means over the blocks of a row, (n, S, channels, down)."""
        weight = self.by_row(self.weight)
        return np.asarray((weight * self.by_row(rest)).sum(-1) / weight.sum(-1))

    def of_blocks(self, rows: Floats) -> Floats:
        """What each block has of its row, (n, S, channels, blocks)."""
        return np.repeat(rows, self.weight.shape[-1] // self.down, axis=-1)

    @property
    def fair(self) -> float:
        """What the variance within a row of blocks lacks, because its mean is one of them."""
        across = self.weight.shape[-1] // self.down
        return float(across / max(across - 1, 1))

    def rows_error_dn2(self, of_block: Floats) -> Floats:
        """Covariance (channels, S, S) that a row has from one of its blocks."""
        weight = self.by_row(self.weight)
        weight = (weight / weight.sum(-1, keepdims=True)).reshape(self.weight.shape)
        both = np.einsum("scb,tcb,cbst->cst", weight, weight, of_block)
        return np.asarray(both / self.down)

    def frames_error(self, own_dn2: Floats, rows_dn2: Floats) -> Floats:
        """Variances (S, 2) that frames have from their blocks and from their rows.

        Args:
            own_dn2: of blocks, (S, channels, blocks).
            rows_dn2: of rows, (channels, S, S).
        """
        shaped = self.shapes * self.weight
        by_row = self.by_row(shaped).sum(-1)
        inner = np.einsum("iscb,jscb,scb->sij", shaped, shaped, own_dn2)
        inner += np.einsum("iscr,jscr,css->sij", by_row, by_row, rows_dn2)
        return np.asarray(np.einsum("sij,sjk,ski->si", self.inverse, inner, self.inverse))


def ruler(of_one: Space, base: Base, bodies: Observation, signal: Floats) -> Ruler:
    """How to read what blocks have in common.

    Args:
        of_one: space of one group of frames of a camera.
        base: the camera.
        bodies: twins of it.
        signal: of blocks above black in DN, (channels, blocks, S).
    """
    root = np.linalg.inv(of_one.whitening)
    lit = np.array([shot in bodies.lit for shot in bodies.shots])
    light = signal.transpose(2, 0, 1) * lit[:, None, None]
    offset = np.broadcast_to(base.gain_dn_per_e[:, None], light.shape)
    return Ruler(
        shapes=np.stack([offset, light]),
        known=root @ root.transpose(0, 1, 3, 2),
        in_time_dn2=bodies.noise / (bodies.samples * bodies.frames),
        down=bodies.grid[0],
    )


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
        """The same of the mean of several groups of frames.

        Args:
            off: the groups' differences from what is expected, (groups, S, channels, blocks). What
                of them is another one in each group is averaged, what all have stays.
        """
        groups = len(off)
        if groups < 2:
            return self
        by = self.by
        fair = np.sqrt(groups / (groups - 1))
        apart = fair * (off - off.mean(axis=0))
        in_time = np.zeros_like(by.known)
        places = np.arange(len(by.in_time_dn2))
        in_time[..., places, places] = by.in_time_dn2.T[:, None]
        rows = by.rows(by.without_frames(apart))
        seen = np.einsum("nscr,nscr->sc", rows, rows) / (groups * by.down)
        own = np.einsum("css->sc", by.rows_error_dn2(in_time))
        whole = np.einsum("css->sc", self.rows_dn2).sum()
        of_rows = _part((seen - own).sum(), whole)
        error = by.frames_error(
            np.broadcast_to(by.in_time_dn2[..., None], by.own_dn2.shape), of_rows * self.rows_dn2
        )
        squares = np.square(by.frames(apart)).mean(axis=0)
        of_frames = [
            _part(_weighed(squares[:, k], error[:, k], one)[0], one)
            for k, one in enumerate(self.frames)
        ]
        offset_e2, light2 = (
            one * (1.0 - part * (1.0 - 1.0 / groups))
            for one, part in zip(self.frames, of_frames, strict=True)
        )
        rows_dn2 = self.rows_dn2 * (1.0 - of_rows * (1.0 - 1.0 / groups))
        return dataclasses.replace(self, rows_dn2=rows_dn2, offset_e2=offset_e2, light2=light2)

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
        """The same of some shots."""
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
    rows_dn2 = _beyond(seen, by_chance, (count - 1) * (by.down - 1)) * by.fair
    error = by.frames_error(np.square(rest).mean(axis=0), rows_dn2)
    amounts = by.frames(off)
    offset_e2, light2 = (_variance(amounts[..., k], error[:, k]) for k in (0, 1))
    if not (rows_dn2.any() or offset_e2 or light2):
        return None, off
    found = Shared(by=by, rows_dn2=rows_dn2, offset_e2=offset_e2, light2=light2)
    return found, np.sqrt(by.fair) * (rest - by.of_blocks(rows)) if rows_dn2.any() else rest


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
