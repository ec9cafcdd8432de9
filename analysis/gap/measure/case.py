"""A capture against a model in two halves of its frames, and what a suspect is worth there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.fit import Fit
from analysis.gap.calibrate.refine import Refined, refined
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
        whole: space of all frames.
        fitting, scoring: the same of the frames that fit and of those that score.
        fit_seen, score_seen: what was seen of each.
        fit_gap: the capture's difference from the model, in the space of the frames that fit.
        fit_left, score_left: what calibration leaves of it in each space.
    """

    known: Fit
    whole: Yardstick
    fitting: Yardstick
    scoring: Yardstick
    fit_seen: Observation
    score_seen: Observation
    fit_gap: Floats
    fit_left: Floats
    score_left: Floats

    @property
    def misfit(self) -> float:
        """Chi-squared of the frames that fit, over what is expected."""
        return float(np.square(self.fit_left).sum() / self.fitting.spread.expected.sum())

    @cached_property
    def bare(self) -> Refined:
        """The model itself, by as few twins as a suspect is calibrated by."""
        return refined(self.known.base, self.fit_seen, self.known.scenery, self.known.effects)


def case_of(known: Fit, whole: Yardstick, fit_seen: Observation, score_seen: Observation) -> Case:
    """A capture against a model.

    Args:
        known: the model.
        whole: the yardstick of all frames.
        fit_seen, score_seen: the two halves, textured.
    """
    spread = whole.spread
    fitting, scoring = yardstick(known, spread, fit_seen), yardstick(known, spread, score_seen)
    gap = fitting.turned.space.of(fit_seen)
    return Case(
        known=known,
        whole=whole,
        fitting=fitting,
        scoring=scoring,
        fit_seen=fit_seen,
        score_seen=score_seen,
        fit_gap=gap,
        fit_left=fitting.turned.left(gap),
        score_left=scoring.turned.left(scoring.turned.space.of(score_seen)),
    )


MISFIT = 1.2
"""Part of the expected chi-squared beyond which a suspect does not fit, and the camera is
calibrated with it."""


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
        off: by how much that is further from the frames than chance makes, as a part of it.
        told: standard errors of what the frames tell of its parameters by themselves, better than
            any fit; None where they were fitted.
    """

    effect: Effect
    base: Base
    score: float
    forward: float
    absorbed: float
    misfit: float
    scenery: Scenery
    model: Fit | None = None
    off: float = np.inf
    told: Mapping[str, float] | None = None

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.effect.name


def candidate(case: Case, shown: Signature, absorbed: float, amount: float = 1.0) -> Candidate:
    """Score a suspect that was fitted on one half.

    Args:
        case: the capture.
        shown: signature of the fitted effect.
        absorbed: part of the signature that calibration takes up.
        amount: part of the signature that least squares found, where it was not followed further.
    """
    whole, fitted, scored = (
        amount * one.turned.left(vector(one.turned.space, shown))
        for one in (case.whole, case.fitting, case.scoring)
    )
    forward = _gain(case.score_left, scored)
    norm = float(scored @ scored)
    back = float(scored @ case.score_left) / norm if norm > 0 else 0.0
    said = forward + _gain(case.fit_left, back * fitted)
    anew = _said_anew(whole, fitted, scored)
    return Candidate(
        effect=shown.effect,
        base=shown.base,
        score=said * anew / variance_along(case.scoring.spread, scored),
        forward=forward,
        absorbed=absorbed,
        misfit=float(np.square(case.fit_left - fitted).sum() / case.fitting.spread.expected.sum()),
        scenery=shown.scenery,
    )


def vector(space: Space, shown: Signature) -> Floats:
    """A signature in standard errors of a space with the same figures, (coordinates,)."""
    return space.vector(shown.figures, shown.means)


def _gain(left: Floats, explained: Floats) -> float:
    """By how much chi-squared falls."""
    return float(explained @ (2 * left - explained))


def _said_anew(whole: Floats, fitted: Floats, scored: Floats) -> float:
    """Part of what the two halves of the frames say of a signature that they do not both say.

    Noise in time is another one in each half. The pattern of the body and the light are the same,
    so that what fits one half by chance fits the other as well: both together say no more than all
    frames do at once. A score of n standard errors is then n^2 for any kind.

    Args:
        whole, fitted, scored: the signature in standard errors of all frames and of each half.
    """
    twice = float(fitted @ fitted + scored @ scored)
    return float(whole @ whole) / twice if twice > 0 else 1.0


BORROWED = 6.0
"""Twins' worth of trust that figures have nothing in common."""


def variance_along(spread: Spread, direction: Floats) -> float:
    """Variance of the twins along a direction; 1 where figures have nothing in common.

    Args:
        spread: of the twins.
        direction: what calibration leaves of a signature.
    """
    norm = float(direction @ direction)
    if norm == 0:
        return 1.0
    along = spread.residuals @ direction / np.sqrt(norm)
    count = len(along)
    return float(max(1.0, (along @ along + BORROWED) / (count + BORROWED)))
