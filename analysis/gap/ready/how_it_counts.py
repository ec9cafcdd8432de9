"""How a camera counts, from its codes alone: the rule of its demosaicer, the steps of its
converter, and a white balance behind it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.arithmetic import (
    IN_FRACTIONS,
    OF_WHOLE_SAMPLES,
    TO_EVEN,
    arithmetic_of,
    rules_of,
)
from analysis.gap.look.code_edges import code_edges
from analysis.gap.look.comb import MOST_CODES
from analysis.gap.look.finer_codes import finer_codes, in_turn
from analysis.gap.look.finer_gains import Gains
from analysis.gap.look.lattices import Lattice, channels_of
from analysis.gap.look.whole_gains import white_balance
from sensor.frames import Frames

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class HowItCounts:
    """What codes tell before any model.

    Attributes:
        arithmetic: the likeliest way; see `sensor.effects.demosaic`.
        rules: all that are left open.
        gains: behind the converter, in all ways that codes leave open.
    """

    arithmetic: int
    rules: tuple[int, ...]
    gains: tuple[Gains, ...] = ()


def how_it_counts(
    shots: Sequence[Frames],
    keys: Sequence[Frames],
    lattices: Sequence[Lattice],
    counts: Mapping[str, Floats],
    bits: int,
    black_dn: float,
) -> HowItCounts:
    """How a camera counts.

    Args:
        shots: all of a capture.
        keys: those that take part in the diagnosis.
        lattices: where the measured samples are.
        counts: histograms of the key shots, by channel.
        bits: how many of the lowest never change.
        black_dn: black level.
    """
    told = arithmetic_of([f.dn for f in keys], lattices)
    coloured = keys[0].pixels == "rgb8"
    if told in (IN_FRACTIONS, *TO_EVEN) and not bits and keys[0].top_dn < MOST_CODES:
        edges = {c: code_edges(shots, lattices, c) for c in channels_of(lattices)}
        # nobody multiplies a mosaic
        finer = (finer_codes(edges, black_dn) if coloured else None) or in_turn(edges)
        if finer is not None:
            alone = coloured and not finer.gains
            rules = rules_of(*finer.rules) if alone else finer.rules
            return HowItCounts(arithmetic=finer.rules[0], rules=rules, gains=finer.gains)
    balance = white_balance(counts, 2**bits) if coloured else None
    if balance is None:
        return HowItCounts(arithmetic=told, rules=rules_of(told) if coloured else (told,))
    gains = Gains(white_balance=balance)
    return HowItCounts(arithmetic=OF_WHOLE_SAMPLES, rules=rules_of(told), gains=(gains,))
