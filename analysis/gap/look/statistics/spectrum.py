"""Power of the noise along the rows and over the image: peaks and slopes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from analysis.gap.look.statistics.group import Group, safe_ratio

FRAMES = 2
"""Frames of a group that are transformed; enough for a peak."""


def spectrum(group: Group) -> dict[str, float]:
    """Slow noise along the rows against fast, and the highest peak of the plane's spectrum."""
    noise = group.noise[:FRAMES]
    noise = noise - noise.mean(axis=(1, 2), keepdims=True)
    waves = fft.rfft(noise, axis=2)
    along = _power(waves).mean(axis=(0, 1))[1:]
    white = float(np.median(along))
    m = len(along)
    found = {
        "slow noise along rows": safe_ratio(float(along[: max(1, m // 32)].mean()), white) - 1.0,
        "medium noise along rows": safe_ratio(float(along[m // 32 : m // 4].mean()), white) - 1.0,
        "fast noise along rows": safe_ratio(float(along[-m // 4 :].mean()), white) - 1.0,
    }
    plane = _power(fft.fft(waves, axis=1, overwrite_x=True)).mean(axis=0)
    plane[0, 0] = 0.0
    typical = float(plane.mean())
    found["highest peak"] = float(np.log(safe_ratio(float(plane.max()), typical) + 1.0))
    return found


def _power(waves: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(np.square(waves.real) + np.square(waves.imag))
