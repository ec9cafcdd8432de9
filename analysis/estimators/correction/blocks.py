"""Native lattices of a channel over all shots: which shots can be used, black, and covariances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.estimators.correction.cells import Cell, measure_cell
from analysis.estimators.correction.patterns import Covariances
from analysis.estimators.correction.shading import basis, degree_of, highest
from analysis.estimators.correction.sites import Lattice, lattices
from analysis.estimators.parts.cautions import CLIPPED, SATURATED
from analysis.estimators.parts.panel_noise import Floats
from sensor.frames import Capture, CaptureError, Shot

LEAST_SITES = 4
"""Least rows and columns of a lattice."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """A cell, with the shot that it is from."""

    shot: Shot
    cell: Cell

    @property
    def in_range(self) -> bool:
        """Whether neither end of the range hides its noise."""
        return self.cell.at_zero < CLIPPED and self.cell.at_top <= SATURATED

    @property
    def told(self) -> bool:
        """Whether its codes tell its noise and levels."""
        return self.in_range and self.cell.told


@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """One native lattice of a panel in all shots."""

    lattice: Lattice
    seen: tuple[Seen, ...]

    @property
    def used(self) -> tuple[Seen, ...]:
        """The shots that tell something."""
        return tuple(s for s in self.seen if s.told)

    @property
    def dark(self) -> NDArray[np.bool_]:
        """Which of the used shots are dark."""
        return np.array([s.shot.dark for s in self.used], dtype=bool)

    @property
    def own_black_dn(self) -> float | None:
        """Mean level of its darks; those too quiet to tell their noise still tell their level."""
        levels = [s.cell.mean_dn for s in self.seen if s.shot.dark and s.in_range]
        return float(np.mean(levels)) if levels else None

    def levels(self, black_dn: float) -> Floats:
        """Mean of each used shot above black, 0 for darks."""
        means = np.array([s.cell.mean_dn for s in self.used])
        return np.where(self.dark, 0.0, means - black_dn)

    def covariances(self, black_dn: float) -> Covariances | None:
        """Covariances of the used shots over sites, less their shading."""
        if not self.used:
            return None
        images = np.stack([s.cell.level_dn for s in self.used])
        lattice = self.lattice
        degree = degree_of(images, lattice.row, lattice.column, highest(*lattice.shape))
        q = basis(lattice.row, lattice.column, degree)
        smooth = (images @ q) @ q.T
        residual = images - smooth
        freedom = images.shape[1] - q.shape[1]
        light = np.where(self.dark[:, None], 0.0, smooth - black_dn)
        return Covariances(
            products=residual @ residual.T / freedom,
            freedom=freedom,
            light=light @ light.T / images.shape[1],
            level=light.mean(axis=1),
            lit=~self.dark,
            error=np.array([s.cell.level_variance_dn2 for s in self.used]),
        )


def measure_blocks(capture: Capture, channel: str, cfa: str | None) -> tuple[Block, ...]:
    """Every native lattice of a channel in every panel.

    Raises:
        CaptureError: where a panel is too small.
    """
    found = []
    for panel in capture.areas:
        for lattice in lattices(capture, panel, channel, cfa):
            if min(lattice.shape) < LEAST_SITES:
                h, w = lattice.shape
                raise CaptureError(
                    f"panel '{panel.name}': {h} x {w} native samples of {channel}",
                    f"expected at least {LEAST_SITES} x {LEAST_SITES}",
                    "make the panel larger",
                )
            found.append(
                Block(
                    lattice=lattice,
                    seen=tuple(
                        Seen(
                            shot=frames.shot,
                            cell=measure_cell(
                                lattice.stacks[frames.shot.label],
                                frames.top_dn,
                                lattice.row,
                                lattice.column,
                            ),
                        )
                        for frames in capture.frames
                    ),
                )
            )
    return tuple(found)
