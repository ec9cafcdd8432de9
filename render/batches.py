"""Independent batches: their estimate, its variance, and how many of them a given noise takes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from foundation.panel import Panel
from render.errors import RenderError

Array = NDArray[np.float64]

BATCHES = 8
"""At least so many: the variance of a pixel is then known to about half of itself."""
MOST_BATCHES = 4096


@dataclass(kw_only=True)
class Sums:
    """Sums over batches of an image Y, a witness Z and their products, pixel by pixel.

    The ratio of the sums estimates the ratio of the expectations; its variance follows from the
    residuals Y - ratio Z of the batches [1]. With a constant witness it is the plain mean.

    [1] W. G. Cochran, Sampling Techniques, 3rd ed., Wiley 1977, ch. 6.
    """

    batches: int = 0
    y: Any = 0.0
    z: Any = 0.0
    yy: Any = 0.0
    yz: Any = 0.0
    zz: Any = 0.0

    def add(self, y: Array, z: Array) -> None:
        """Take in one batch."""
        self.batches += 1
        self.y, self.z = self.y + y, self.z + z
        self.yy, self.yz, self.zz = self.yy + y * y, self.yz + y * z, self.zz + z * z

    def estimate(self, scale: ArrayLike = 1.0) -> tuple[Array, Array]:
        """The ratio times a scale, and its variance; 0 where the witness saw nothing."""
        factor = np.asarray(scale, dtype=np.float64)
        blind = self.z <= 0
        z = np.where(blind, 1.0, self.z)
        ratio = np.where(blind, 0.0, self.y / z)
        residual = np.maximum(self.yy - 2 * ratio * self.yz + ratio**2 * self.zz, 0.0)
        spread = self.batches / (self.batches - 1) * residual / z**2
        return ratio * factor, np.where(blind, 0.0, spread) * factor**2


def relative_noise(
    rate: NDArray[Any], variance: NDArray[Any], clear: tuple[Panel, ...]
) -> tuple[float, ...]:
    """Standard error over mean in the noisiest panel, for each channel."""
    worst = np.zeros(3)
    for panel in clear:
        mean = np.mean(rate[panel.window], axis=(0, 1), dtype=np.float64)
        rms = np.sqrt(np.mean(variance[panel.window], axis=(0, 1), dtype=np.float64))
        worst = np.maximum(worst, np.divide(rms, mean, out=np.zeros(3), where=mean > 0))
    return tuple(float(value) for value in worst)


def batches_needed(done: int, reached: float, noise: float) -> int:
    """How many batches the asked noise takes in all, when so many have left `reached`.

    Raises:
        RenderError: when it is more than anybody would wait for.
    """
    if reached <= noise:
        return done
    needed = max(done + 1, math.ceil(1.05 * done * (reached / noise) ** 2))
    if needed > MOST_BATCHES:
        raise RenderError(
            f"a noise of {noise:g} would take about {needed} batches, and {done} leave"
            f" {reached:.2g}",
            f"expected at most {MOST_BATCHES}",
            "ask for more samples or more noise",
        )
    return needed
