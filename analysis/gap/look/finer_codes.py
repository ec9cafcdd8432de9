"""Converters of more bits than leave the camera, with a white balance behind them or without, told
by where their codes end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analysis.gap.look.code_edges import CodeEdges
from analysis.gap.look.finer_gains import Gains, finer_gains, fits
from sensor.interpolation import COUNTING, Counting

MOST_ERROR = 0.1
"""Beyond which photon transfer tells no gain."""

LEAST_FALL = 60.0
"""Of chi-squared, where codes are wide and narrow in turn."""

LEAST_OF_GAINS = 120.0
"""The same by gains of two colours. Of 44 cameras without any, each with another effect, the
largest was 34, by a filter over time, and 42 behind JPEG; of 37 cameras by somebody else one had
80, behind another demosaicer (docs/another-camera.md, seed 81). Of 44 cameras with gains of
sixteenths 31 had more, 230 to 7,500; most others rounded once more behind them."""


@dataclass(frozen=True, kw_only=True)
class FinerCodes:
    """A converter of more bits, and gains behind it.

    Attributes:
        rules: the ways of counting that it may be; see `sensor.effects.demosaic`.
        gains: behind it, the likeliest first; others put edges of darks elsewhere. None are needed
            where codes are wide and narrow in turn.
        fall: of chi-squared of all colours by the likeliest.
    """

    rules: tuple[int, ...]
    gains: tuple[Gains, ...] = ()
    fall: float = 0.0


STEPS = sorted({c.steps for c in COUNTING if c.steps is not None and c.steps > 1})


def in_turn(edges: Mapping[str, CodeEdges]) -> FinerCodes | None:
    """The converter of more bits whose codes are wide and narrow in turn, as even ones take the
    halves of steps on either side; None where codes are equally wide, or not alike in all colours.

    Args:
        edges: by channel.
    """
    falls = {steps: sum(_to_even(one, steps) for one in edges.values()) for steps in STEPS}
    steps = max(STEPS, key=lambda one: falls[one])
    fit = all(fits(one, _to_even(one, steps)) for one in edges.values())
    if not fit or falls[steps] < LEAST_FALL:
        return None
    return FinerCodes(rules=(COUNTING.index(Counting(steps=steps)),), fall=falls[steps])


def finer_codes(edges: Mapping[str, CodeEdges], black_dn: float) -> FinerCodes | None:
    """Finer codes and gains that explain where codes end; None where these are not needed.

    Args:
        edges: of red, green and blue.
        black_dn: black level.
    """
    green = edges["G"]
    if any(one.noise_slope_dn <= 0 or one.slope_error > MOST_ERROR for one in edges.values()):
        return None
    # without gains all colours are alike: half-way between codes, or wide and narrow in turn
    without = 0.0
    best: FinerCodes | None = None
    for steps in STEPS:
        ways = [(c.up, k) for k, c in enumerate(COUNTING) if c.steps == steps]
        fitting = {}
        for up in {up for up, _ in ways}:
            falls = {channel: 0.0 if up else _to_even(one, steps) for channel, one in edges.items()}
            without = max(without, sum(falls.values()))
            if fits(green, falls["G"]):
                fitting[up] = falls["G"]
        if not fitting or not (gains := finer_gains(edges, steps, black_dn, LEAST_OF_GAINS / 4.0)):
            continue  # combs of less power than that take off so much once in 300 cameras
        up = max(fitting, key=lambda one: fitting[one])
        fall = fitting[up] + sum(gains[0].falls)
        if best is None or fall > best.fall:
            rules = tuple(rule for one, rule in ways if one == up)
            best = FinerCodes(rules=rules, gains=gains, fall=fall)
    if best is None or best.fall - without < LEAST_OF_GAINS:
        return None
    return best


def _to_even(own: CodeEdges, steps: float) -> float:
    """By how much chi-squared is less where, without a gain, every even code takes both halves."""
    moved = np.where(own.codes % 2 == 0, -0.5, 0.5) / steps
    return float(own.fall(moved[None])[0])
