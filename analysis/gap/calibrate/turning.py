"""Knobs of a base and parameters of effects, turned by so much along the directions of a fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.nuisance import Directions
from analysis.gap.camera.base import Base
from analysis.gap.camera.handles import moved
from sensor.colours import CHANNELS
from sensor.effect import Effect

Floats = NDArray[np.float64]

MOST_GAIN_STEP = 0.4
"""Of the logarithm of a gain or of a level, either way, in one step."""

CHARGE_RATE = "e-/s"
"""The unit of what gathers in darks."""


def turn(base: Base, ways: Directions, amounts: Floats, *, still: Sequence[str] = ()) -> Base:
    """A base with its knobs turned, but for those that stay still."""
    raised = _raised(ways, amounts)
    for knob, amount in zip(ways.knobs, amounts, strict=False):
        if knob.name in still:
            continue
        by = float(amount)
        if knob.name == "gain" or knob.name.startswith("level"):
            by = _gain_step(by)
        if knob.name == "shown":
            by = _as_bright(base.shown_e_per_s, by, float(np.mean(raised or 0.0)))
        base = base.moved(knob.name, knob.channel, by)
    return base


def tune(effect: Effect, ways: Directions, amounts: Floats) -> Effect:
    """An effect with its parameters moved, each inside its range."""
    steps = zip(ways.tuned, map(float, amounts[len(ways.knobs) :]), strict=False)
    moves = {h: by for h, by in steps if h.effect == effect.name}
    raised = _raised(ways, amounts)
    units = {p.name: p.unit for p in effect.parameters()}
    for h in [h for h in moves if raised and units[h.parameter] == CHARGE_RATE]:
        rate, gain = getattr(effect, h.parameter), float(np.mean(raised))
        if h.channel is not None:
            rate, gain = rate[CHANNELS[h.channel]], raised[h.channel]
        moves[h] = _as_bright(rate, moves[h], gain)
    return moved(effect, moves)


def _as_bright(rate: float, by: float, gain: float) -> float:
    """By how much a rate is moved for a gain times the rate that is what both steps promise.

    Darks tell the product to a thousandth. Along its hyperbola a gain goes with a rate, and on a
    straight step of both nothing would be as bright as before.

    Args:
        rate: in electrons per second.
        by: its own step.
        gain: that of the logarithm of the gain.
    """
    return float((rate * (1.0 + gain) + by) * np.exp(-gain) - rate)


def _raised(ways: Directions, amounts: Floats) -> list[float]:
    """Steps of the logarithm of the gain, by channel or of all."""
    named = zip(ways.knobs, amounts, strict=False)
    return [_gain_step(float(amount)) for knob, amount in named if knob.name == "gain"]


def _gain_step(by: float) -> float:
    return float(np.clip(by, -MOST_GAIN_STEP, MOST_GAIN_STEP))
