"""How far a capture is from its model: by family, in total, and how rarely chance goes as far.

    G = (n' n - expected) / expected        0 on average where nothing is wrong

Here n is what calibration leaves of the difference, in standard errors that have a part of the
difference itself in them (`MODEL_ERROR`), as normal deviates of equal chance (`believed`). What is
expected of a family is what twins of the model show of themselves, each against the others: what
figures have in common, and what calibration takes up, is in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.calibrate.calibration import Calibration
from analysis.gap.calibrate.fit import Fit
from analysis.gap.calibrate.space import MODEL_ERROR
from analysis.gap.look.families import OF_A_BODY
from analysis.gap.look.observation import Observation
from analysis.gap.measure.twins_spread import Spread, believed

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Yardstick:
    """What a capture is held against.

    Attributes:
        turned: the space of the capture, less what calibration takes up.
        spread: of the model's twins.
    """

    turned: Calibration
    spread: Spread


def yardstick(known: Fit, spread: Spread, seen: Observation) -> Yardstick:
    """The yardstick of a capture.

    Args:
        known: the model.
        spread: of its twins.
        seen: the capture, textured.
    """
    return Yardstick(turned=known.calibration_for(seen), spread=spread)


@dataclass(frozen=True, kw_only=True)
class Distance:
    """How far a capture is from a model.

    Attributes:
        total: G over all coordinates.
        by_family: G by family.
        p_by_family: chance of a family's chi-squared where nothing is wrong.
        p_value: the smallest of these, corrected for their number.
    """

    total: float
    by_family: dict[str, float]
    p_by_family: dict[str, float]
    p_value: float


TELLS_NOTHING = 1e-3
"""Expected chi-squared below which a family has no chance of its own: all of its figures are of a
picture that nobody stated."""


def distance(left: Floats, spread: Spread) -> Distance:
    """Distance of what is left of a capture.

    Args:
        left: what calibration leaves of its difference from the model, in standard errors,
            (coordinates + directions,), of which the coordinates alone count.
        spread: of the model's twins.
    """
    squares = np.square(believed(left[: len(spread.families)], len(spread.residuals)))
    by_family, chances = {}, {}
    for k, name in enumerate(spread.names):
        found = float(squares[spread.families == name].sum())
        expected, variance = float(spread.expected[k]), float(spread.variance[k])
        by_family[name] = (found - expected) / max(expected, 1e-9)
        chances[name] = 1.0
        if expected > TELLS_NOTHING:
            scale, freedom = variance / (2 * expected), 2 * expected**2 / variance
            chances[name] = float(stats.chi2.sf(found / scale, freedom))
    smallest = min(chances.values())
    return Distance(
        total=float((squares.sum() - spread.expected.sum()) / spread.expected.sum()),
        by_family=by_family,
        p_by_family=chances,
        p_value=float(1.0 - (1.0 - smallest) ** len(chances)),
    )


def floor(known: Fit, spread: Spread, half: Observation, other: Observation) -> float:
    """G of one half of the frames from the other: what no model of this capture can get below.

    Only figures of noise in time count. The pattern of a body is the same in both halves.

    Args:
        known: the model.
        spread: of its twins.
        half, other: the two halves, textured.
    """
    in_time = np.array([key.family not in OF_A_BODY for key in known.bodies.keys])
    first, second = half.figures.mean(axis=0), other.figures.mean(axis=0)
    off = np.maximum(np.abs(first), np.abs(second)) - np.abs(known.bodies.figures.mean(axis=0))
    variance = known.variances * (1 / half.groups + 1 / other.groups) + (MODEL_ERROR * off) ** 2
    z = believed((first - second) / np.sqrt(variance), len(spread.residuals))
    return float((np.square(z[in_time]).sum() - in_time.sum()) / spread.expected.sum())
