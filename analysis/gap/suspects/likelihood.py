"""Which suspect these frames are likelier from, each judged by its own errors.

    deviance = -2 log L = z^T R^-1 z + log det C,    C = W R W

A score tells by how much chi-squared falls in units of the model's errors without the suspect. One
that makes figures scatter, from frame to frame or from body to body, is wronged by that: its right
amount leaves as much chi-squared as the scatter is wide. One that only makes every figure
uncertain gains by nothing here, since the determinant of its covariance is what it pays. It pays
once for what figures have in common, R, and not once for each of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from analysis.gap.calibrate.calibration import calibration
from analysis.gap.calibrate.fit import seeds_of, spaces_by, together, twins, with_keys
from analysis.gap.calibrate.space import MODEL_ERROR
from analysis.gap.calibrate.wide import fair
from analysis.gap.camera.base import Base
from analysis.gap.camera.handles import free_parameters
from analysis.gap.look.observation import Observation
from analysis.gap.measure.case import Candidate, Case
from analysis.gap.measure.in_common import correlations
from analysis.gap.measure.twins_spread import believed

JUDGES = 24
"""Twins that tell the errors of a model."""

PER_PARAMETER = 12.0
"""What a further parameter costs: about log n of the figures that tell it in each half of the
frames, as Schwarz found."""

CLEAR_SCORE = 300.0
"""Score of the best from which likelihoods are asked: determinants are read from a few twins, and
differ by some ten by chance."""


def deviance(case: Case, found: Candidate) -> float:
    """-2 log likelihood of the frames that score, up to what all suspects have in common.

    In the units of a score: noise in time counts for the other half of the frames as well, what
    stays from frame to frame is the same in both.

    Args:
        case: the capture.
        found: the suspect, fitted on the other frames.
    """
    known = case.known
    effects = [*known.effects, found.effect]
    judges = twins(found.scenery, found.base, seeds_of(JUDGES), effects)
    bodies = together(map(known.textured, judges.values()))
    return _deviance(case, found.base, with_keys(bodies, known.bodies.keys))


def deviance_without(case: Case) -> float:
    """-2 log likelihood of the frames that score by the model alone, as `deviance` counts it."""
    bodies = case.known.bodies
    few = slice(None, JUDGES)
    fewer = dataclasses.replace(bodies, figures=bodies.figures[few], means=bodies.means[few])
    return _deviance(case, case.known.base, fewer)


def _deviance(case: Case, base: Base, bodies: Observation) -> float:
    known, seen = case.known, case.score_seen
    space, of_one = spaces_by(bodies, base, known.scenery, seen)
    left = calibration(space, known.ways).left(space.of(seen))
    alike = case.scoring.spread.alike
    halves = 2.0 / (1.0 + alike)
    z = believed(left[: len(alike)], JUDGES)
    found = float(halves @ (np.square(z) + 2.0 * space.log_widths))
    twins = fair(bodies.groups) * (bodies.figures - of_one.expected_figures) / of_one.spread
    off = seen.figures.mean(axis=0) - space.expected_figures
    of_chance = np.maximum(1.0 - np.square(MODEL_ERROR * off / space.spread), 0.0)
    for place, correlation in correlations(space.keys, twins, of_chance):
        own = z[place]
        more = own @ np.linalg.solve(correlation, own) - own @ own
        found += float(halves[place].mean() * (more + np.linalg.slogdet(correlation)[1]))
    return found


def cost(case: Case, found: Candidate) -> float:
    """Deviance of a suspect, and what its parameters cost."""
    return deviance(case, found) + PER_PARAMETER * len(free_parameters(found.effect))


def judged(case: Case, rivals: Sequence[Candidate], unexplained: float) -> list[Candidate]:
    """Rivals with scores that are as far apart as their likelihoods.

    The likeliest is worth what it has over no suspect at all, if that is more than any score: the
    right one may be wronged by the errors of the model without it.

    Args:
        case: the capture.
        rivals: suspects, each at its fitted strength.
        unexplained: chi-squared beyond what is expected, without any suspect.
    """
    most = max((c.score for c in rivals), default=0.0)
    wronged = most < CLEAR_SCORE <= unexplained
    if not rivals or (not wronged and (len(rivals) < 2 or most < CLEAR_SCORE)):
        return list(rivals)
    found = [cost(case, one) for one in rivals]
    gained = deviance_without(case) - min(found)
    if wronged and gained < CLEAR_SCORE:
        return list(rivals)
    most = max(most, gained)
    return [
        dataclasses.replace(c, score=most - (one - min(found)))
        for c, one in zip(rivals, found, strict=True)
    ]
