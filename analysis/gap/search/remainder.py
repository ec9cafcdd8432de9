"""What the error of one effect's model may leave, and what it cannot have left.

A model that is right to a part e of what its effect does leaves up to e z_i of a statistic that was
z_i off without it. So a later effect of signature l is held against what is left, r, with errors
that are as much wider,

    w_i = 1 / (1 + e^2 z_i^2),    score = (sum of w l r)^2 / (sum of w l^2)

which is its plain score where the first effect did nothing, and little where it did much.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.measure.case import Case
from analysis.gap.measure.signature import Signature, hold, signed

Floats = NDArray[np.float64]

RIGHT_TO = 0.15
"""Part of what an effect does by which its model may be wrong, in any statistic."""


def score_apart(later: str, shown: Sequence[Signature], without: Case, now: Case) -> float:
    """Score of an effect in what the model with another one cannot have left of that.

    Args:
        later: name of the effect.
        shown: how the suspects show.
        without, now: the capture against the models without and with the other effect.
    """
    turned, left = now.fitting.turned, now.fit_left
    weights = 1.0 / (1.0 + np.square(RIGHT_TO * _was_off(without, now)))
    best = 0.0
    for one in shown:
        if one.effect.name != later:
            continue
        remains = hold(one.on(turned.space.keys), turned, left).left
        along = float((weights * remains) @ left)
        power = float((weights * remains) @ remains)
        if power > 0 and (along > 0 or signed(type(one.effect))):
            best = max(best, along**2 / power)
    return best


def _was_off(without: Case, now: Case) -> Floats:
    """How far the statistics and blocks of a model were off without its effect; what was not looked
    at then was not off.
    """
    keys, before = (one.fitting.turned.space.keys for one in (now, without))
    place = {key: index for index, key in enumerate(before)}
    found = np.array([place.get(key, -1) for key in keys], dtype=int)
    figures = np.where(found < 0, 0.0, without.fit_left[found])
    blocks = np.zeros(len(now.fit_left) - len(keys))
    seen = without.fit_left[len(before) :][: len(blocks)]
    blocks[: len(seen)] = seen
    return np.concatenate([figures, blocks])
