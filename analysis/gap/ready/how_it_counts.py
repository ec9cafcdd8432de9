"""How a camera counts, from its codes alone: the rule of its demosaicer, the steps of its
converter, and a white balance behind it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.calibrate.counting import by_rule
from analysis.gap.camera.base import Base
from analysis.gap.look.arithmetic import (
    IN_FRACTIONS,
    OF_WHOLE_SAMPLES,
    TO_EVEN,
    arithmetic_of,
    rules_of,
)
from analysis.gap.look.code_edges import code_edges
from analysis.gap.look.comb import MOST_CODES, NEAR
from analysis.gap.look.finer_codes import finer_codes, in_turn
from analysis.gap.look.finer_gains import Gains
from analysis.gap.look.gains_by_teeth import MOST, gains_by_teeth
from analysis.gap.look.lattices import Lattice, channels_of
from analysis.gap.look.whole_gains import white_balance
from foundation.cores import in_order
from sensor.effects.white_balance import WhiteBalance
from sensor.frames import Frames

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class HowItCounts:
    """What codes tell before any model.

    Attributes:
        arithmetic: the likeliest way; see `sensor.effects.demosaic`.
        rules: all that are left open.
        gains: behind the converter, in all ways that codes leave open.
        slight: gains so near to 1 that they are suspected, as other effects are.
        corners: whether measured greens are averaged with those at their corners.
    """

    arithmetic: int
    rules: tuple[int, ...]
    gains: tuple[Gains, ...] = ()
    slight: tuple[WhiteBalance, ...] = ()
    corners: bool = False

    def of(self, base: Base) -> Base:
        """A camera whose frames look like that one's, as this one counts."""
        ruled = by_rule(base, self.arithmetic)
        return ruled.averaged() if self.corners else ruled


def how_it_counts(
    shots: Sequence[Frames],
    keys: Sequence[Frames],
    lattices: Sequence[Lattice],
    counts: Mapping[str, Floats],
    bits: int,
    black_dn: float,
    *,
    fills_in: bool,
) -> HowItCounts:
    """How a camera counts.

    Args:
        shots: all of a capture.
        keys: those that take part in the diagnosis.
        lattices: where the measured samples are.
        counts: histograms of the key shots, by channel.
        bits: how many of the lowest never change.
        black_dn: black level.
        fills_in: whether it fills in colours.
    """
    told = arithmetic_of([f.dn for f in keys], lattices)
    finer = None
    if told in (IN_FRACTIONS, *TO_EVEN) and not bits and keys[0].top_dn < MOST_CODES:
        channels = channels_of(lattices)
        each = in_order(lambda channel: code_edges(shots, lattices, channel), channels)
        edges = dict(zip(channels, each, strict=True))
        # where nothing is filled in only whole codes are multiplied
        finer = (finer_codes(edges, black_dn) if fills_in else None) or in_turn(edges)
    if finer is not None and (finer.gains or not fills_in):
        return HowItCounts(arithmetic=finer.rules[0], rules=finer.rules, gains=finer.gains)
    gains = _of_whole_codes(counts, bits, black_dn)
    if not fills_in:
        return HowItCounts(arithmetic=told, rules=(told,), gains=_of_a_mosaic(gains))
    near = all(_beyond(one) < NEAR for one in gains)
    if finer is None and not near:
        return HowItCounts(arithmetic=OF_WHOLE_SAMPLES, rules=rules_of(told), gains=gains)
    rules = (told,) if finer is None else finer.rules
    slight = tuple(one.white_balance for one in gains) if near else ()
    return HowItCounts(arithmetic=rules[0], rules=rules_of(*rules), slight=slight)


HALVES = (0.0, 1e-5, -1e-5)
"""Of gains, by which halves go to the even code, all up, or all down: 1.3 times 5 is one."""


def _of_a_mosaic(gains: Sequence[Gains]) -> tuple[Gains, ...]:
    """Gains of whole codes of a mosaic, by where halves may go. Few teeth of gains near 1 tell
    nothing there: no colours were filled in that tell whether codes were whole.
    """

    def moved(one: Gains, by: float) -> Gains:
        had = one.white_balance
        red, blue = had.red_gain + by, had.blue_gain + by
        balance = dataclasses.replace(had, red_gain=red, blue_gain=blue, whole_codes=1.0)
        return dataclasses.replace(one, white_balance=balance)

    return tuple(moved(one, by) for one in gains if _beyond(one) >= NEAR for by in HALVES)


def _of_whole_codes(counts: Mapping[str, Floats], bits: int, black_dn: float) -> tuple[Gains, ...]:
    """Gains by the few teeth of channels where they are near 1, else by their combs."""
    by_comb = white_balance(counts, 2**bits)
    by_teeth = gains_by_teeth(counts, black_dn)
    if by_comb is None:
        return by_teeth
    both = tuple(filled for one in by_teeth if (filled := _filled(one, by_comb)) is not None)
    return both or (Gains(white_balance=by_comb),)


def _filled(by_teeth: Gains, by_comb: WhiteBalance) -> Gains | None:
    """With a comb's gain where that is too far from 1 for few teeth, or these say nothing; None
    where both speak of other origins.
    """
    balance, more = by_teeth.white_balance, {}
    for name in ("red_gain", "blue_gain"):
        few, comb = getattr(balance, name), getattr(by_comb, name)
        if abs(comb - 1.0) > MOST or (few == 1.0 and comb != 1.0):
            more[name] = comb
    if more and by_comb.about_black != balance.about_black:
        return None
    return dataclasses.replace(by_teeth, white_balance=dataclasses.replace(balance, **more))


def _beyond(gains: Gains) -> float:
    """By how much the larger of them is not 1."""
    balance = gains.white_balance
    return max(abs(balance.red_gain - 1.0), abs(balance.blue_gain - 1.0))
