"""Least squares for what the blocks of a shot have in common: offset and light of a frame, rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]


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
    def for_the_mean(self) -> float:
        """Factor of what the variance within a row lacks, because its mean is one of them."""
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


def ruler(known: Floats, base: Base, bodies: Observation, signal: Floats) -> Ruler:
    """How to read what blocks have in common.

    Args:
        known: covariance of blocks between shots, (channels, blocks, S, S), by a space.
        base: the camera.
        bodies: twins of it.
        signal: of blocks above black in DN, (channels, blocks, S).
    """
    lit = np.array([shot in bodies.lit for shot in bodies.shots])
    light = signal.transpose(2, 0, 1) * lit[:, None, None]
    offset = np.broadcast_to(base.gain_dn_per_e[:, None], light.shape)
    return Ruler(
        shapes=np.stack([offset, light]),
        known=known,
        in_time_dn2=bodies.noise / (bodies.samples * bodies.frames),
        down=bodies.grid[0],
    )
