"""Codes that are left out before a demosaicer are made again by it, and behind it they are not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.gap.look.lattices import SITES, Lattice
from analysis.gap.look.missing_codes import missing_everywhere
from analysis.gap.verdict import caps
from sensor.effect import Effect
from sensor.effects.adc_dnl import AdcDnl
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.gamma import Gamma
from sensor.effects.interference import Interference
from sensor.effects.jpeg import Jpeg

LATTICES = tuple(
    Lattice(name=name, channel=name[0], dy=dy, dx=dx, step=2)
    for name, (dy, dx) in zip(("R", "G1", "G2", "B"), SITES, strict=True)
)
LEAVES_OUT = np.arange(256) // 4 * 4 + 1
"""A table with every fourth code; a converter with such codes has steps of four."""


def mosaic() -> NDArray[np.uint8]:
    """Four frames of grey, 120 codes with a standard deviation of 20."""
    codes = np.random.default_rng(5).normal(120.0, 20.0, (4, 96, 128))
    return np.clip(np.round(codes), 0, 255).astype(np.uint8)


def coloured(codes: NDArray[Any]) -> NDArray[np.uint8]:
    """Means of the two pixels beside, for every colour and pixel that another colour measured."""
    beside = np.round((np.roll(codes, 1, 2) + np.roll(codes, -1, 2).astype(float)) / 2)
    filled = np.repeat(beside[..., None], 3, axis=3)
    for lattice in LATTICES:
        at = (slice(None), slice(lattice.dy, None, 2), slice(lattice.dx, None, 2))
        filled[(*at, "RGB".index(lattice.channel))] = codes[at]
    return filled.astype(np.uint8)


@pytest.mark.parametrize(
    ("frames", "behind"),
    [
        (coloured(mosaic()), False),
        (coloured(LEAVES_OUT[mosaic()]), False),
        (LEAVES_OUT[coloured(mosaic())], True),
        (LEAVES_OUT[mosaic()], False),
    ],
    ids=["none", "before the colours", "behind the colours", "a raw camera"],
)
def test_codes_that_are_left_out_behind_the_colours_are_told(
    frames: NDArray[Any], behind: bool
) -> None:
    """Of every fourth code alone, means of two make one of the three that are missing between."""
    assert missing_everywhere([frames], LATTICES, 255) == behind
    view = SimpleNamespace(lattices=LATTICES, top_dn=255)
    setting: Any = SimpleNamespace(
        key_frames=[SimpleNamespace(dn=frames, shot=SimpleNamespace(dark=False))],
        scenery=SimpleNamespace(view=view),
    )
    most = caps.MOST_AGAINST if behind else 1.0
    assert caps.most_of_a_converter(AdcDnl(), (), setting) == most
    assert caps.most_of_a_converter(AdcDnl(unit_mismatch=0.2), (), setting) == caps.MOST_AGAINST
    assert caps.most_of_a_converter(BitTruncation(), (), setting) == 1.0


@pytest.mark.parametrize(
    ("other", "most"),
    [(Gamma(), caps.MOST_AGAINST), (Jpeg(), caps.MOST_AGAINST), (Interference(), 1.0)],
)
def test_what_is_done_to_pictures_hides_how_a_converter_counts(other: Effect, most: float) -> None:
    nothing: Any = SimpleNamespace(
        key_frames=[], scenery=SimpleNamespace(view=SimpleNamespace(lattices=LATTICES, top_dn=255))
    )
    assert caps.most_of_a_converter(AdcDnl(), (other, AdcDnl()), nothing) == most
