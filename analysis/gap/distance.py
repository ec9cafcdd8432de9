"""How far a capture is from its model: by family, in total, and how rarely chance goes as far.

    G = (delta' C^-1 delta - d) / d        0 on average where nothing is wrong

The d of a family is what twins of the model show of themselves, each against the others: what
figures have in common, and what calibration takes up, is in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.fit import Fit, fair
from analysis.gap.nuisance import Calibration
from analysis.gap.observe import IMAGE, OF_A_BODY, Observation
from analysis.gap.space import PRIOR_FREEDOM

Floats = NDArray[np.float64]

BORROWED = 8.0
"""Degrees of freedom with which a family's spread is drawn to that of independent figures."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Yardstick:
    """A model's own spread.

    Attributes:
        turned: the space of the capture, less what calibration takes up.
        families: family of each coordinate.
        names: the families.
        expected: chi-squared that a twin has of each family.
        variance: of that chi-squared.
        residuals: the twins themselves in this space, one row each.
        errors: standard errors of the amounts of all directions, from the twins' own.
    """

    turned: Calibration
    families: NDArray[np.str_]
    names: tuple[str, ...]
    expected: Floats
    variance: Floats
    residuals: Floats
    errors: Floats


def yardstick(known: Fit, seen: Observation) -> Yardstick:
    """Measure the twins of a model against each other.

    Args:
        known: the model.
        seen: the capture that will be compared, textured.
    """
    turned = known.calibration_for(seen)
    families = turned.space.families
    names = tuple(dict.fromkeys(families))
    one = known.calibration_of_twins()
    bodies = known.bodies
    count = bodies.groups
    differences = [fair(count) * one.space.of(bodies, slice(k, k + 1)) for k in range(count)]
    residuals = np.array([one.left(difference) for difference in differences])
    believed = [_believed(r[: len(families)], count) for r in residuals]
    squares = np.array([[np.sum(np.square(z[families == n])) for n in names] for z in believed])
    expected = squares.mean(axis=0)
    size = np.array([(families == n).sum() for n in names])
    usual = 2.0 * np.maximum(expected, 1e-9) * np.maximum(expected / size, 1.0)
    variance = ((count - 1) * squares.var(axis=0, ddof=1) + BORROWED * usual) / (
        count - 1 + BORROWED
    )
    return Yardstick(
        turned=turned,
        families=families,
        names=names,
        expected=expected,
        variance=np.maximum(variance, 1e-12),
        residuals=residuals,
        errors=_errors(known, one, np.array([one.amounts(d) for d in differences]), seen.groups),
    )


def _errors(known: Fit, one: Calibration, amounts: Floats, groups: int) -> Floats:
    """Standard errors of amounts that are read from so many groups of one camera body.

    What a direction changes in the noise is averaged over groups, what it changes in the pattern of
    a body is not.
    """
    ways = known.ways
    body = np.isin(one.space.families, [IMAGE, *OF_A_BODY])
    columns = np.array(
        [one.space.vector(f, m) for f, m in zip(ways.figures, ways.means, strict=True)]
    )
    squares = np.square(columns)
    share = squares[:, body].sum(axis=1) / np.maximum(squares.sum(axis=1), 1e-300)
    scale = share + (1 - share) / groups + 1 / len(amounts)
    return np.asarray(amounts.std(axis=0, ddof=1) * np.sqrt(scale))


def _believed(z: Floats, count: int) -> Floats:
    """Differences in standard errors that are themselves estimates, as normal ones of equal chance.

    A spread that is read from a few twins is sometimes too small: Student's t. Large differences
    stay as they are, they need no chance.
    """
    freedom = count - 1 + PRIOR_FREEDOM
    size = np.minimum(np.abs(z), 8.0)
    normal = stats.norm.isf(stats.t.sf(size, freedom))
    return np.asarray(np.where(np.abs(z) < 8.0, normal, np.abs(z) - 8.0 + normal))


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


def distance(left: Floats, rod: Yardstick) -> Distance:
    """Distance of what is left of a capture.

    Args:
        left: see `Yardstick.left`.
        rod: the model's own spread.
    """
    squares = np.square(_believed(left[: len(rod.families)], len(rod.residuals)))
    by_family, chances = {}, {}
    for k, name in enumerate(rod.names):
        found = float(squares[rod.families == name].sum())
        expected, variance = float(rod.expected[k]), float(rod.variance[k])
        by_family[name] = (found - expected) / max(expected, 1e-9)
        scale = variance / (2 * expected) if expected > 0 else 1.0
        freedom = 2 * expected**2 / variance
        chances[name] = float(stats.chi2.sf(found / scale, freedom)) if expected > 0 else 1.0
    known = [name for name in rod.names if chances[name] <= 1]
    smallest = min(chances.values())
    return Distance(
        total=float((squares.sum() - rod.expected.sum()) / rod.expected.sum()),
        by_family=by_family,
        p_by_family=chances,
        p_value=float(1.0 - (1.0 - smallest) ** len(known)),
    )
