"""What the whole codes of a capture tell of effects, before any camera is calibrated."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.chroma import shared_colours
from analysis.gap.look.curve import curve, nearly_straight
from analysis.gap.look.jpeg_tables import quality
from analysis.gap.ready.hints import DirectReading
from sensor.effects.bit_truncation import BitTruncation
from sensor.effects.chroma_subsampling import ChromaSubsampling
from sensor.effects.gamma import Gamma
from sensor.effects.jpeg import Jpeg
from sensor.effects.white_balance import WhiteBalance
from sensor.frames import Frames

Floats = NDArray[np.float64]


def told_by_codes(
    keys: Sequence[Frames],
    bits: int,
    counts: Mapping[str, Floats],
    black_dn: float,
    slight: Sequence[WhiteBalance],
) -> dict[str, DirectReading]:
    """Lost bits, the exponent of a curve behind the converter, gains that are nearly 1, the quality
    of JPEG, and how many pixels share a colour, by name of the effect.

    Args:
        keys: frames of the key shots.
        bits: lowest bits that are always empty.
        counts: how often each code occurs, by lattice.
        black_dn: a first black level.
        slight: gains of a white balance that are nearly 1, the likeliest first.
    """
    told: dict[str, DirectReading] = {}
    if bits:
        told[BitTruncation.name] = DirectReading(hints={"bits": float(bits)})
    bent = nearly_straight(counts, black_dn) or curve(counts, black_dn)
    if bent is not None:
        # a comb says nothing of codes near black, where there may be a chord; few teeth nothing of
        # where it begins
        where = {} if bent.origin_dn or not bent.sharp else {"about_black": 0.0}
        hints = {"exponent": bent.exponent, **where}
        told[Gamma.name] = DirectReading(hints=hints, exact=bent.sharp)
    else:
        likelier: DirectReading | None = None
        for one in reversed(slight):
            likelier = DirectReading(hints=dataclasses.asdict(one), instead=likelier)
            told[WhiteBalance.name] = likelier
    whole = [f.dn for f in keys if not f.shot.dark and f.pixels in ("rgb8", "mono8")]
    if (tables := quality(whole)) is not None:
        told[Jpeg.name] = DirectReading(hints={"quality": float(tables)})
    # a codec does that as well, besides
    elif (way := shared_colours(whole)) is not None:
        told[ChromaSubsampling.name] = DirectReading(hints=way, exact=False)
    return told
