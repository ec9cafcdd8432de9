"""What a model's own twins differ by, each from the others: the measure of every distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from analysis.gap.calibrate.body_share import share_of_amounts
from analysis.gap.calibrate.figure_errors import PRIOR_FREEDOM
from analysis.gap.calibrate.fit import Fit, by_the_others
from analysis.gap.calibrate.wide import fair
from analysis.gap.look.observation import Key

Floats = NDArray[np.float64]

BORROWED = 8.0
"""Degrees of freedom with which a family's spread is drawn to that of independent figures."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spread:
    """Spread of the twins of a model.

    Attributes:
        families: family of each coordinate.
        alike: correlation between two halves of the frames, 1 of what stays from frame to frame.
        names: the families.
        expected: chi-squared that a twin has of each family.
        variance: of that chi-squared.
        residuals: what calibration leaves of the twins, one row each.
        amounts: what calibration takes up of them, (twins, directions).
        of_body: part of the variance of each amount that is the body's.
    """

    families: NDArray[np.str_]
    alike: Floats
    names: tuple[str, ...]
    expected: Floats
    variance: Floats
    residuals: Floats
    amounts: Floats
    of_body: Floats

    def errors(self, groups: int) -> Floats:
        """Standard errors of the amounts of all directions, read from so many groups of one body.

        Noise is averaged over groups, the pattern of a body is not.
        """
        scale = self.of_body + (1 - self.of_body) / groups + 1 / len(self.amounts)
        return np.asarray(self.amounts.std(axis=0, ddof=1) * np.sqrt(scale))


def spread_of(known: Fit, groups: int) -> Spread:
    """Measure the twins of a model against each other.

    Args:
        known: the model.
        groups: of the capture that they are for.
    """
    one, bodies, ways = known.calibration_of_twins(), known.bodies, known.ways
    families = one.space.families
    names = tuple(dict.fromkeys(families))
    count = bodies.groups
    differences = [fair(count) * one.space.of(bodies, slice(k, k + 1)) for k in range(count)]
    residuals = np.array([one.left(difference) for difference in differences])
    residuals[:, : len(bodies.keys)] *= by_the_others(bodies, known.variances, known.scenery)
    trusted = [believed(r[: len(families)], count) for r in residuals]
    squares = np.array([[np.sum(np.square(z[families == n])) for n in names] for z in trusted])
    expected = squares.mean(axis=0)
    size = np.array([(families == n).sum() for n in names])
    usual = 2.0 * np.maximum(expected, 1e-9) * np.maximum(expected / size, 1.0)
    variance = ((count - 1) * squares.var(axis=0, ddof=1) + BORROWED * usual) / (
        count - 1 + BORROWED
    )
    # twins are one group of frames; of a capture's many, what is left is one body in every shot
    in_common = _in_common(known.shares, groups)
    times = np.array([_times_shown(one.space.keys, in_common, name) for name in names])
    variance = np.maximum(variance, 2.0 * expected * times)
    of_image = np.ones(len(families) - len(known.shares))
    columns = np.array(
        [one.space.vector(f, m) for f, m in zip(ways.figures, ways.means, strict=True)]
    )
    shown = np.square(columns)
    by_figures = shown @ np.concatenate([known.shares, of_image])
    by_figures /= np.maximum(shown.sum(axis=1), 1e-300)
    amounts = np.array([one.amounts(difference) for difference in differences])
    again = [
        one.amounts(fair(count) * one.space.of(known.again, slice(k, k + 1)))
        for k in range(known.again.groups)
    ]
    return Spread(
        families=families,
        alike=np.concatenate([_in_common(known.shares, groups / 2), of_image]),
        names=names,
        expected=expected,
        variance=np.maximum(variance, 1e-12),
        residuals=residuals,
        amounts=amounts,
        of_body=share_of_amounts(amounts[: len(again)], np.array(again), by_figures),
    )


def _in_common(shares: Floats, groups: float) -> Floats:
    """Part of the variance of means over so many groups that is the body's."""
    return np.asarray(shares / (shares + (1.0 - shares) / groups))


def _times_shown(keys: Sequence[Key], in_common: Floats, family: str) -> float:
    """How many shots say the same of a body, in the mean: 1 where each says something else.

    The variance of the sum of n squares with a correlation of r between any two is that of
    independent ones times 1 + (n - 1) r^2.
    """
    own = [place for place, key in enumerate(keys) if key.family == family]
    if not own:
        return 0.0
    shots = len(own) / len({(keys[place].lattice, keys[place].statistic) for place in own})
    return float(1.0 + (shots - 1.0) * np.square(in_common[own]).mean())


def believed(z: Floats, count: int) -> Floats:
    """Differences in standard errors that are themselves estimates, as normal ones of equal chance.

    A spread that is read from a few twins is sometimes too small: Student's t. Large differences
    stay as they are, they need no chance.
    """
    freedom = count - 1 + PRIOR_FREEDOM
    size = np.minimum(np.abs(z), 8.0)
    normal = stats.norm.isf(stats.t.sf(size, freedom))
    return np.asarray(np.where(np.abs(z) < 8.0, normal, np.abs(z) - 8.0 + normal))
