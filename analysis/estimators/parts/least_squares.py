"""Straight fits, unweighted as in the paper, with standard errors from those of the points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.estimators.parts.panel_noise import Floats


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Least squares of points on a design.

    Attributes:
        operator: the fit as a matrix, parameters = operator @ points.
        parameters: in the order of the design's columns.
        misfit: how many times larger the residuals' squares are than the points' errors say,
            never below 1; errors are to be widened by its root where the model does not follow
            the points.
    """

    operator: Floats
    parameters: Floats
    misfit: float

    def covariance(self, of_points: Floats) -> Floats:
        """Covariance of the parameters, given that of the points."""
        return np.asarray(self.operator @ of_points @ self.operator.T)


def fit(design: Floats, points: Floats, covariance: Floats) -> Fit:
    """Fit points (n,) by a design (n, p); `covariance` (n, n) is what the points' errors say."""
    operator = np.asarray(np.linalg.pinv(design), dtype=np.float64)
    parameters = operator @ points
    left = np.eye(len(points)) - design @ operator
    expected = float(np.trace(left @ covariance @ left.T))
    found = float(np.sum((left @ points) ** 2))
    spare = len(points) - design.shape[1]
    misfit = found / expected if spare > 0 and expected > 0 else 1.0
    return Fit(operator=operator, parameters=parameters, misfit=max(1.0, misfit))
