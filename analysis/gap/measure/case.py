"""A capture against a model in two halves of its frames, and what a suspect is worth there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.fit import Fit
from analysis.gap.calibrate.space import Space
from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.observation import Observation
from analysis.gap.measure.distance import Yardstick, yardstick
from analysis.gap.measure.signature import Signature
from analysis.gap.measure.twins_spread import Spread
from sensor.effect import Effect

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A capture against a model, in two halves of its frames.

    Attributes:
        known: the model, calibrated.
        fitting, scoring: spaces of the frames that fit and of those that score.
        fit_seen, score_seen: what was seen of each.
        fit_gap: the capture's difference from the model, in the space of the frames that fit.
        fit_left, score_left: what calibration leaves of it in each space.
    """

    known: Fit
    fitting: Yardstick
    scoring: Yardstick
    fit_seen: Observation
    score_seen: Observation
    fit_gap: Floats
    fit_left: Floats
    score_left: Floats


def case_of(known: Fit, spread: Spread, fit_seen: Observation, score_seen: Observation) -> Case:
    """A capture against a model.

    Args:
        known: the model.
        spread: of its twins.
        fit_seen, score_seen: the two halves, textured.
    """
    fitting, scoring = yardstick(known, spread, fit_seen), yardstick(known, spread, score_seen)
    gap = fitting.turned.space.of(fit_seen)
    return Case(
        known=known,
        fitting=fitting,
        scoring=scoring,
        fit_seen=fit_seen,
        score_seen=score_seen,
        fit_gap=gap,
        fit_left=fitting.turned.left(gap),
        score_left=scoring.turned.left(scoring.turned.space.of(score_seen)),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """A suspect at its fitted strength.

    Attributes:
        effect: with parameters that the frames which fit gave it.
        base: the camera, calibrated together with it.
        score: fall of chi-squared of each half at the strength that the other half gives.
        forward: fall of chi-squared on the frames that score, at the strength that was fitted.
        absorbed: part of the signature that calibration takes up.
        misfit: chi-squared that it leaves of the frames that fitted it, over what is expected.
        scenery: shots, under the light as the frames show it to a camera with the effect.
        model: everything around the camera with it, where a search for it has come to know that.
    """

    effect: Effect
    base: Base
    score: float
    forward: float
    absorbed: float
    misfit: float
    scenery: Scenery
    model: Fit | None = None

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


def candidate(
    case: Case, shown: Signature, base: Base, absorbed: float, amount: float = 1.0
) -> Candidate:
    """Score a suspect that was fitted on one half.

    Args:
        case: the capture.
        shown: signature of the fitted effect.
        base: the camera with which it was fitted.
        absorbed: part of the signature that calibration takes up.
        amount: part of the signature that least squares found, where it was not followed further.
    """
    fitted = amount * case.fitting.turned.left(vector(case.fitting.turned.space, shown))
    scored = amount * case.scoring.turned.left(vector(case.scoring.turned.space, shown))
    forward = float(_gain(case.score_left, scored).sum())
    norm = float(scored @ scored)
    back = float(scored @ case.score_left) / norm if norm > 0 else 0.0
    in_common = _in_common(case.scoring.spread, scored)
    said = _said_anew(case.scoring.spread, len(scored))
    return Candidate(
        effect=shown.effect,
        base=base,
        score=float(said @ (_gain(case.score_left, scored) + _gain(case.fit_left, back * fitted)))
        / in_common,
        forward=forward,
        absorbed=absorbed,
        misfit=float(np.square(case.fit_left - fitted).sum() / case.fitting.spread.expected.sum()),
        scenery=shown.scenery,
    )


def vector(space: Space, shown: Signature) -> Floats:
    """A signature in units of standard errors."""
    return space.vector(shown.figures, shown.means)


def _gain(left: Floats, explained: Floats) -> Floats:
    """By how much chi-squared falls, coordinate by coordinate."""
    return explained * (2 * left - explained)


def _said_anew(spread: Spread, size: int) -> Floats:
    """What each coordinate of the two halves of the frames counts.

    Noise in time is another one in each half. The pattern of the body and the light are the same,
    so that what fits one half by chance fits the other as well: both together say it once. The mean
    of two figures with a correlation of r has (1 + r) / 2 of the variance of each. A score of n
    standard errors is then n^2 for either kind.
    """
    alike = np.ones(size)
    alike[: len(spread.alike)] = spread.alike
    return np.asarray(1.0 / (1.0 + alike))


BORROWED = 6.0
"""Twins' worth of trust that figures have nothing in common."""


def _in_common(spread: Spread, direction: Floats) -> float:
    """Variance of the twins along a direction; 1 where figures have nothing in common."""
    norm = float(direction @ direction)
    if norm == 0:
        return 1.0
    along = spread.residuals @ direction / np.sqrt(norm)
    count = len(along)
    return float(max(1.0, (along @ along + BORROWED) / (count + BORROWED)))
