"""Four random words for every address: Philox 4x32 with seven rounds, written out.

Dr.Jit's own generator makes the same words in a loop of seven turns; written out, without a loop's
masks, and with the upper half of each product by itself, they take half the time.

Reference: Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011: seven rounds pass
all of TestU01's BigCrush.
"""

from __future__ import annotations

from typing import Any

import drjit as dr

ROUNDS = 7
_FACTORS = (0xD2511F53, 0xCD9E8D57)
_STEPS = (0x9E3779B9, 0xBB67AE85)
"""Both of the paper: what the counter is multiplied by, and what is added to the key a round."""

Words = tuple[Any, Any, Any, Any]


def words(key: Any, lane: Any, frame: Any) -> Words:
    """Four words of 32 bits, each uniform and independent of the others.

    Args:
        key: 64 bits, one for all.
        lane, frame: unsigned indices, flat arrays of one size: the address of the words.
    """
    kind: Any = type(lane)
    low, high = kind(key >> 32), kind(key)
    a, b, c, d = lane, frame, kind(0), kind(0)
    for _ in range(ROUNDS):
        upper = dr.mul_hi(a, kind(_FACTORS[0])), dr.mul_hi(c, kind(_FACTORS[1]))
        lower = a * _FACTORS[0], c * _FACTORS[1]
        a, b, c, d = upper[1] ^ b ^ low, lower[1], upper[0] ^ d ^ high, lower[0]
        low, high = low + _STEPS[0], high + _STEPS[1]
    return a, b, c, d


def fractions(four: Words) -> list[Any]:
    """Numbers uniform in [0, 1) from the upper 23 bits of words."""
    number: Any = dr.float32_array_t(type(four[0]))
    return [number(word >> 9) * 2.0**-23 for word in four]
