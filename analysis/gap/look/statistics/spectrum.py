"""Power of the noise along the rows and over the image: peaks and slopes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from analysis.gap.look.statistics.group import Array, Figures, Group, safe_ratio

ENOUGH = 50_000
"""Samples that show a peak: of lattices with as many one frame of a group is transformed, else two.
"""


def spectrum(group: Group) -> Figures:
    """Slow noise along the rows against fast, and the highest peak of the plane's spectrum."""
    noise = group.noise[:, : 1 if group.pixels >= ENOUGH else 2]
    noise = noise - noise.mean(axis=(2, 3), keepdims=True)
    waves = fft.rfft(noise, axis=3)
    along = _power("kfhw,kfhw->kw", waves)[:, 1:]
    white = np.median(along, axis=1)
    m = along.shape[1]
    bands = {
        "slow": along[:, : max(1, m // 32)],
        "medium": along[:, m // 32 : m // 4],
        "fast": along[:, -m // 4 :],
    }
    found: Figures = {
        f"{name} noise along rows": safe_ratio(band.mean(axis=1), white) - 1.0
        for name, band in bands.items()
    }
    plane = _power("kfhw,kfhw->khw", fft.fft(waves, axis=2, overwrite_x=True))
    plane[:, 0, 0] = 0.0
    highest, typical = plane.max(axis=(1, 2)), plane.mean(axis=(1, 2))
    found["highest peak"] = np.log(safe_ratio(highest, typical) + 1.0)
    return found


def _power(sums: str, waves: NDArray[Any]) -> Array:
    """Squared magnitudes, summed as `sums` says; real and imaginary parts lie side by side."""
    parts = np.ascontiguousarray(waves).view(np.float32)
    by_part = np.einsum(sums, parts, parts)
    return np.asarray(by_part[..., ::2] + by_part[..., 1::2])
