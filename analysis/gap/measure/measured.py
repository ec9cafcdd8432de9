"""A capture held against a model: all of its key frames, and the halves that fit and that score."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.fit import Fit
from analysis.gap.look.observation import Observation
from analysis.gap.measure.case import Case, case_of
from analysis.gap.measure.distance import Distance, Yardstick, distance, floor, yardstick
from analysis.gap.measure.twins_spread import spread_of
from analysis.gap.ready.setting import halves

Floats = NDArray[np.float64]

LEAST_TOLD = 0.5
"""Part of what is known of an amount that frames must tell for it to have an error."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """A capture's distance from a model.

    Attributes:
        rod: space of all key frames, and the spread of the model's twins.
        left: what calibration leaves of the difference there.
        whole: distance of all key frames.
        case: the two halves of the frames.
        held: distance of the half that scores.
        floor: G of one half from the other, which no model can get below but by chance.
        amounts: how far each direction should still move, its errors in the same order.
        errors: standard errors of these; infinite where frames tell little.
    """

    rod: Yardstick
    left: Floats
    whole: Distance
    case: Case
    held: Distance
    floor: float
    amounts: Floats
    errors: Floats

    @property
    def held_error(self) -> float:
        """Standard error of the distance of the half that scores."""
        spread = self.rod.spread
        return float(np.sqrt(spread.variance.sum()) / spread.expected.sum())


def measured(known: Fit, seen: Observation) -> Measured:
    """Distance of what was seen of the key shots from a model.

    Args:
        known: the model.
        seen: every group of the key shots.
    """
    textured = known.textured(seen)
    fit_half, score_half = halves(textured)
    spread = spread_of(known, textured.groups)
    rod = yardstick(known, spread, textured)
    gap = rod.turned.space.of(textured)
    left = rod.turned.left(gap)
    case = case_of(known, rod, fit_half, score_half)
    return Measured(
        rod=rod,
        left=left,
        whole=distance(left, spread),
        case=case,
        held=distance(case.score_left, spread),
        floor=floor(known, spread, fit_half, score_half),
        amounts=rod.turned.amounts(gap),
        errors=errors_of(rod, textured.groups),
    )


def errors_of(rod: Yardstick, groups: int) -> Floats:
    """Standard errors of amounts by the frames, (directions,).

    Twins show by how much amounts scatter, but all are under the light that is known, while an
    effect may look like what nobody knows of it: the larger of both errors counts. A prior of the
    amount itself keeps steps short and is no knowledge. Without it a variance H of which it is the
    part h would be H / (1 - h), and what scatters as much larger.

    Args:
        rod: of the capture.
        groups: of its frames.
    """
    told = 1.0 - rod.turned.held
    with np.errstate(divide="ignore", invalid="ignore"):
        by_priors = rod.turned.errors / np.sqrt(told)
        by_twins = rod.spread.errors(groups) / told
        return np.where(told > LEAST_TOLD, np.fmax(by_priors, by_twins), np.inf)
