"""What the frames themselves say of parameters that a search could not guess: a period, a place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft, ndimage

from analysis.gap.lattices import Lattice
from sensor.frames import Frames

Floats = NDArray[np.float64]

Hints = Mapping[str, float]
"""Where a search for a parameter of that name should begin."""

HINT_FRAMES = 8


def period_px(stacks: Sequence[Frames], lattices: tuple[Lattice, ...]) -> float:
    """Period along the read-out of the strongest wave in the noise, in pixels.

    The spectrum is that of a whole frame in the order it is read, so that waves along the rows,
    waves across them and all between are one peak each.
    """
    best, found = 0.0, 23.7
    for stack in stacks:
        noise = _mosaic(stack, lattices)
        series = noise.reshape(len(noise), -1)
        power = np.square(np.abs(fft.rfft(series, axis=1))).mean(axis=0)
        # drifts of whole frames are not waves, and nothing is faster than two pixels
        low = 8
        peak = low + int(np.argmax(power[low:]))
        height = float(power[peak] / np.median(power[low:]))
        if height > best:
            best, found = height, series.shape[1] / _between(power, peak)
    return max(found, 2.0)


MOST_BITS = 8


def empty_bits(stacks: Sequence[Frames], lattices: Sequence[Lattice]) -> int:
    """Lowest bits that have one value in all measured samples: nothing was ever counted in them."""
    codes = [
        np.unique(lattice.of(stack.dn[:HINT_FRAMES])) for stack in stacks for lattice in lattices
    ]
    used = np.unique(np.concatenate(codes)).astype(np.int64)
    for bits in range(MOST_BITS, 0, -1):
        if len(used) > 1 and len(np.unique(used % 2**bits)) == 1:
            return bits
    return 0


def _between(power: Floats, peak: int) -> float:
    """Place of a peak between the points of a spectrum, by the parabola of its logarithm."""
    if not 0 < peak < len(power) - 1:
        return float(peak)
    left, middle, right = np.log(power[peak - 1 : peak + 2] + 1e-30)
    bend = left - 2 * middle + right
    return float(peak + (0.5 * (left - right) / bend if bend < 0 else 0.0))


def _mosaic(stack: Frames, lattices: tuple[Lattice, ...]) -> NDArray[np.float32]:
    """Noise of measured samples in their places, each colour in units of its own."""
    dn = np.asarray(stack.dn[:HINT_FRAMES])
    plane = np.zeros(dn.shape[:3], dtype=np.float32)
    for lattice in lattices:
        channel = dn[..., "RGB".index(lattice.channel)] if dn.ndim == 4 else dn
        samples = channel[:, lattice.dy :: lattice.step, lattice.dx :: lattice.step]
        noise = samples.astype(np.float32)
        noise = noise - noise.mean(axis=0)
        size = float(noise.std()) or 1.0
        plane[:, lattice.dy :: lattice.step, lattice.dx :: lattice.step] = noise / size
    return plane


def brightest(left: Floats, grid: tuple[int, int]) -> tuple[float, float]:
    """Where the residual image is most above the model over a wide area: parts of width, height.

    Args:
        left: residual blocks in standard errors, (shots, channels, blocks).
        grid: blocks down and across.
    """
    image = np.clip(left, -10, 10).mean(axis=(0, 1)).reshape(grid)
    smooth = ndimage.gaussian_filter(image, max(1.0, grid[0] / 12))
    y, x = np.unravel_index(int(np.argmax(smooth)), grid)
    return (float(x) + 0.5) / grid[1], (float(y) + 0.5) / grid[0]
