"""Directions that calibration may take, read from twins: they are there by other random numbers.

By random numbers that took no part, a direction d is d again, and what calibration leaves of it is
the noise of both readings: |left| / |d| of a direction that is known. A suspect that looks like d
leaves that part of its whole size, however much of it calibration should take up.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest

from analysis.gap.calibrate.calibration import calibration
from analysis.gap.calibrate.fit import FIRST_SEED, Fit, around, twins
from analysis.gap.calibrate.nuisance import Directions, directions, moved_twins
from analysis.gap.look.observe import _kept
from analysis.gap.ready.setting import look
from analysis.identifiability.known import base_of
from sensor.record import record
from tests.short import PROTOCOL, camera, light
from tests.twins import twin

OTHER_SEEDS = (FIRST_SEED + 60, FIRST_SEED + 61)
GROUPS = 2

MOST_LEFT = {
    "black": 0.15,
    "level:lamp": 0.085,
    "read": 0.15,
    "gain": 0.2,
    "fpn": 0.23,
    "prnu": 0.25,
}
"""What is left of a step, of its length, in the mean over channels. With a step of 0.05 DN for the
black level, half the step for fixed patterns, and with the noise of every block, it was 0.47 for
the black level, 0.11 for the light and 0.28 for fixed patterns; it is 0.08, 0.05 and 0.17."""


@functools.cache
def both() -> tuple[Fit, Directions]:
    """A camera with everything around it, and its directions by other random numbers."""
    known = camera().with_body(2)
    taken = record(known, PROTOCOL, {"lamp": light().rate_e_per_s}, seed=2)
    setting = look(taken, {"lamp": light()})
    assert setting is not None
    fit = around(base_of(known, ["lamp"]), setting.scenery)
    references = {seed: twin(setting.scenery, fit.base, seed=seed) for seed in OTHER_SEEDS}
    moved = moved_twins(fit.base, setting.scenery, references)
    return fit, directions(fit.base, setting.scenery, moved.seen_by(fit.textured))


@pytest.mark.whole
@pytest.mark.parametrize("name", MOST_LEFT)
def test_a_direction_is_the_same_by_other_random_numbers(name: str) -> None:
    fit, other = both()
    space = fit.space(GROUPS)
    turned = calibration(space, fit.ways)
    parts = []
    for k, knob in enumerate(other.knobs):
        if knob.name == name:
            again = space.vector(other.figures[k], other.means[k])
            parts.append(np.linalg.norm(turned.left(again)) / np.linalg.norm(again))
    assert len(parts) == len(fit.base.channels)
    assert np.mean(parts) < MOST_LEFT[name], parts


def test_twins_that_are_begun_ahead_are_those_one_by_one() -> None:
    """To the last bit, in the order of their seeds, whatever was seen before."""
    fit, _ = both()
    asked = OTHER_SEEDS[::-1]
    together = twins(fit.scenery, fit.base, asked)
    assert tuple(together) == asked
    _kept.clear()
    for seed, seen in together.items():
        alone = twin(fit.scenery, fit.base, seed=seed)
        assert alone.keys == seen.keys
        assert np.array_equal(alone.figures, seen.figures)
        assert np.array_equal(alone.means, seen.means)
