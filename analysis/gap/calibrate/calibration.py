"""A space less what calibration takes up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.nuisance import Directions
from analysis.gap.calibrate.space import Space

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """A space less what calibration takes up.

    Attributes:
        space: where figures have units of their standard errors.
        q: orthonormal columns over the coordinates and the priors, (coordinates + directions, m):
            as many as directions that the coordinates and priors tell apart.
        solve: from projections on these to amounts of each direction, (directions, m).
        priors: one over the standard deviation that each amount has beforehand, (directions,); 0
            where free.
    """

    space: Space
    q: Floats
    solve: Floats
    priors: Floats

    def left(self, vector: Floats) -> Floats:
        """What calibration cannot take up of a vector, or of several.

        Args:
            vector: in standard errors, (coordinates,), or (rows, coordinates).

        Returns:
            what is left in standard errors, (..., coordinates + directions): of the coordinates,
            then of the measurement that each direction's prior is.
        """
        n = self.q.shape[0] - vector.shape[-1]
        padded = np.concatenate([vector, np.zeros((*vector.shape[:-1], n))], axis=-1)
        return np.asarray(padded - (padded @ self.q) @ self.q.T)

    def amounts(self, vector: Floats) -> Floats:
        """How much of each direction calibration takes up, in its own unit, (directions,).

        Args:
            vector: in standard errors, (coordinates,).
        """
        return np.asarray(self.solve @ (self.q[: len(vector)].T @ vector))

    @property
    def errors(self) -> Floats:
        """Standard errors of the amounts, by these errors of figures and by all priors."""
        return np.asarray(np.linalg.norm(self.solve, axis=1))

    @property
    def held(self) -> Floats:
        """Part of what is known of each amount that is its own prior: 1 where it shows nowhere."""
        return np.asarray(np.square(self.priors * self.errors))


def calibration(space: Space, ways: Directions) -> Calibration:
    """What is left of a space when all directions are taken out.

    A prior of standard deviation s is one more measurement: that the amount is 0 +- s.
    """
    # of darks alone there is no direction: nothing that light could take up
    columns = np.zeros((len(space.log_widths), len(ways.prior)))
    for k, (figures, means) in enumerate(zip(ways.figures, ways.means, strict=True)):
        columns[:, k] = space.vector(figures, means)
    size = np.linalg.norm(columns, axis=0)
    with np.errstate(divide="ignore"):
        priors = np.where(np.isinf(ways.prior), 0.0, 1.0 / ways.prior)
    # a direction that shows nowhere is held where it is
    priors = np.where(size + priors < 1e-9, 1.0, priors)
    scale = np.hypot(size, priors)
    matrix = np.vstack([columns, np.diag(priors)]) / scale
    squares, v = np.linalg.eigh(matrix.T @ matrix)
    good = squares > 1e-10 * squares.max(initial=0.0)
    length = np.sqrt(squares[good])
    q = matrix @ (v[:, good] / length)
    return Calibration(
        space=space, q=q, solve=(v[:, good] / length) / scale[:, None], priors=priors
    )
