"""What the error of one effect's model cannot have left is another effect's."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.gap.look.observation import Key
from analysis.gap.measure.signature import Signature
from analysis.gap.search.remainder import RIGHT_TO, score_apart
from sensor.effects.lens_distortion import LensDistortion

HALF = 25
KEYS = tuple(
    Key(shot="lit", lattice="G", family="tails", statistic=str(k)) for k in range(2 * HALF)
)
FIRST = np.repeat([1.0, 0.0], HALF)
"""Statistics that the first effect moves."""

OFF = 100.0
"""Standard errors by which it does."""


def case(left: np.ndarray, keys: tuple[Key, ...] = KEYS) -> Any:
    """What is left of statistics of which calibration takes up nothing."""
    space = SimpleNamespace(keys=keys, vector=lambda figures, means: figures)
    turned = SimpleNamespace(space=space, left=lambda vector: vector)
    return SimpleNamespace(fitting=SimpleNamespace(turned=turned), fit_left=left)


def shown(figures: np.ndarray) -> Signature:
    """A suspect that moves statistics so."""
    return Signature(
        effect=LensDistortion(k1=0.01), keys=KEYS, figures=figures, means=np.zeros(0),
        plain=(figures, np.zeros(0)), sets=1, base=None, scenery=None,  # type: ignore[arg-type]
    )  # fmt: skip


@pytest.mark.parametrize(
    ("what", "left", "score"),
    [
        ("where the first did nothing it has its whole score", 2.0 * (1 - FIRST), 4.0 * HALF),
        ("a tenth of the first is none of it, though it is 1,250 by itself", 10.0 * FIRST, 0.0),
        ("a part of both is what the first did not move", 10.0 * FIRST + 2.0 * (1 - FIRST),
         4.0 * HALF),
    ],
)  # fmt: skip
def test_a_later_effect_counts_where_the_first_did_nothing(
    what: str, left: np.ndarray, score: float
) -> None:
    """With weights w = 1 / (1 + (e z)^2) of n statistics that were z off and 1 of n others, a
    signature of ones finds (n a w + n b)^2 / (n w + n) in a and b: b^2 n, to a few w of it."""
    found = score_apart(
        "lens_distortion", [shown(np.ones(2 * HALF))], case(OFF * FIRST), case(left)
    )
    a, b = left[0], left[-1]
    w = 1.0 / (1.0 + (RIGHT_TO * OFF) ** 2)
    assert found == pytest.approx(HALF * (a * w + b) ** 2 / (w + 1.0), rel=1e-9), what
    assert found == pytest.approx(score, abs=0.3 * HALF)


def test_what_was_not_looked_at_without_the_first_was_not_off() -> None:
    before = case(OFF * FIRST[:HALF], KEYS[:HALF])
    found = score_apart("lens_distortion", [shown(1 - FIRST)], before, case(3.0 * (1 - FIRST)))
    assert found == pytest.approx(9.0 * HALF)
    assert score_apart("vibration", [shown(1 - FIRST)], before, case(3.0 * (1 - FIRST))) == 0.0
