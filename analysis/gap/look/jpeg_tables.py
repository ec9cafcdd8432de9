"""The quality at which frames went through JPEG, told by the comb of their cosine coefficients.

A coefficient c of a block of 8 x 8 pixels that was quantized by a step T is a multiple of it, but
for the rounding of the pixels afterwards, which adds noise of standard deviation s:

    mean of cos(2 pi c / T) = exp(-2 pi^2 s^2 / T^2)

Of frames that never were compressed it is 0. Multiples of T are also those of its parts, but a part
is less clear of the noise, so that the quality whose tables agree best is the one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from analysis.bias.rounding import ROUNDING_DN2

Floats = NDArray[np.float64]

LUMA = np.array([0.299, 0.587, 0.114])
"""Of ITU-R BT.601, as JFIF has it."""

TABLE = np.array(
    [
        [16, 11, 10, 16, 24, 40, 51, 61],
        [12, 12, 14, 19, 26, 58, 60, 55],
        [14, 13, 16, 24, 40, 57, 69, 56],
        [14, 17, 22, 29, 51, 87, 80, 62],
        [18, 22, 37, 56, 68, 109, 103, 77],
        [24, 35, 55, 64, 81, 104, 113, 92],
        [49, 64, 78, 87, 103, 121, 120, 101],
        [72, 92, 95, 98, 112, 100, 103, 99],
    ]
)
"""Steps of luminance, rows of vertical frequency: ITU-T T.81, table K.1."""

BLOCK = 8
"""Pixels along the side of a block that is transformed: ITU-T T.81."""

MOST_BLOCKS = 800
"""Of a shot; taken at equal distances from all of it."""

ABOVE_ZERO = 0.6
"""Coefficients below this part of a step are zeros, which agree with every table."""

LEAST_COUNT = 20
LEAST_FREQUENCIES = 5
"""Of each of so many frequencies there must be so many coefficients that are not zero; with fewer
the frames have too little in them, and a ramp would do for a comb."""

FIRST_TOOTH = 0.2
"""Part of these that are one step from zero, or more: small coefficients are the most frequent. Of
a part of the true step there are none."""

AGREES = 0.6
"""Part of the mean cosine behind rounding from which frames have been compressed. For steps of 1,
which most coefficients pass, it is 0.12; for larger ones 0.4 and more, where the mean over five
frequencies of 20 coefficients that mean nothing has an error of 0.07."""


def steps(quality: int) -> NDArray[np.int64]:
    """Quantization steps of luminance, as libjpeg scales the table of the standard."""
    percent = 5000 // quality if quality < 50 else 200 - 2 * quality
    return np.asarray(np.clip((TABLE * percent + 50) // 100, 1, 255), dtype=np.int64)


def quality(stacks: Sequence[NDArray[Any]]) -> int | None:
    """Quality of the tables on whose comb the coefficients of frames fall; None where on none.

    Args:
        stacks: frames of 8 bits as they came, (n, H, W) or (n, H, W, 3), one stack per shot.
    """
    if not stacks:
        return None
    found = np.concatenate([_coefficients(stack) for stack in stacks])
    best, clearest = None, 0.0
    for candidate in range(100, 0, -1):
        by = steps(candidate)[_TOLD]
        size = np.abs(found) / by
        counted = size > ABOVE_ZERO
        count = counted.sum(axis=0)
        told = count >= LEAST_COUNT
        if told.sum() < LEAST_FREQUENCIES:
            break
        agree = (np.cos(2 * np.pi * size) * counted).sum(axis=0)[told] / count[told]
        # coefficients have the noise of pixels; of three channels they have less
        behind = np.exp(-2 * np.pi**2 * ROUNDING_DN2 / np.square(by[told]))
        first = (counted & (size < 1 + ABOVE_ZERO)).sum(axis=0)[told] / count[told]
        clear = float(agree.mean())
        if clear > max(clearest, AGREES * behind.mean()) and first.mean() > FIRST_TOOTH:
            best, clearest = candidate, clear
    return best


_TOLD = np.array([[u % 4 > 0 or v % 4 > 0 for v in range(BLOCK)] for u in range(BLOCK)])
"""All frequencies but those at which the coefficients of whole pixels are on a comb anyway."""


def _coefficients(stack: NDArray[Any]) -> NDArray[np.float32]:
    """Cosine coefficients of the told frequencies, (blocks, frequencies)."""
    h, w = (n // BLOCK * BLOCK for n in stack.shape[1:3])
    a_frame = h // BLOCK * (w // BLOCK)
    codes = stack[: max(1, MOST_BLOCKS // max(1, a_frame)), :h, :w].astype(np.float32)
    plane = codes @ LUMA.astype(np.float32) if codes.ndim == 4 else codes
    blocks = plane.reshape(len(plane), h // BLOCK, BLOCK, w // BLOCK, BLOCK)
    blocks = np.moveaxis(blocks, 2, 3).reshape(-1, BLOCK, BLOCK)
    blocks = blocks[:: max(1, len(blocks) // MOST_BLOCKS)]
    return np.asarray(fft.dctn(blocks, axes=(1, 2), norm="ortho")[:, _TOLD])
