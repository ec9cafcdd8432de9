"""How many photosites leak, and how much: what stands out of the dark in every frame.

The excess of a hot photosite is exponential, and an exponential forgets: what lies above a
threshold t is above it by the same mean m again, whatever the threshold. Of samples x that end at
the largest code, some at it, the likeliest m and the density are

    m = sum of (x - t) / number below the largest code
    density = number / sum of exp(-t / m) over all photosites

each with a relative error of one over the root of the number, for who has leaks is chance as well.
A fit by twins cannot do as well: theirs are others, in other places, and a few dozen differ.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.lattices import Lattice
from analysis.gap.look.shots import HINT_FRAMES
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.moments import gains_of
from analysis.gap.ready.setting import Setting
from sensor.frames import Frames
from sensor.thermal import darkness_s

STANDS_OUT = 8.0
"""Standard errors above its surroundings at which a sample leaks: no fixed pattern is as wide."""

ALIKE = 2.0
"""Times the excess of one half of the frames that the other one has at most, and that of the middle
one of all frames: a leak is as large in every frame, and flashes are not.
"""

MEDIAN_OF = 5
"""Samples across and down whose median is what surrounds one."""

LEAST_NUMBER = 4
"""Leaking samples that tell how many and how much: each to a half or better. Of 80 nulls of the
bench (seed 30) one has as many, 7, by its uneven dark current."""


def hot(setting: Setting) -> DirectReading | None:
    """Density and rate of hot photosites; None where too few stand out of the longest dark.

    Args:
        setting: the capture.
    """
    longest = longest_dark(setting)
    if longest is None:
        return None
    gain = gains_of(setting)
    found = leaking(longest, setting.scenery.view.lattices, gain)
    if found is None:
        return None
    density, excess_e, number = found
    hints = {"density": density, "rate_e_per_s": excess_e / darkness_s(longest.shot)}
    errors = {name: value / float(np.sqrt(number)) for name, value in hints.items()}
    return DirectReading(hints=hints, errors=errors)


def longest_dark(setting: Setting) -> Frames | None:
    """The dark shot of the longest exposure; None without any that gathers charge."""
    darks = [s for s in setting.key_frames if s.shot.dark and s.shot.exposure_s > 0]
    return max(darks, key=lambda stack: stack.shot.exposure_s, default=None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Leaks:
    """Samples of one lattice that leak.

    Attributes:
        where: which of them do, (h, w).
        excess_dn: of each, above its surroundings.
        threshold_dn: from which one counts.
        clipped: how many are at the largest code.
    """

    where: NDArray[np.bool_]
    excess_dn: NDArray[np.float32]
    threshold_dn: float
    clipped: int


def leaks_of(stack: Frames, lattice: Lattice) -> Leaks:
    """Samples that stand out of a dark shot by as much in every frame.

    Args:
        stack: frames of the shot.
        lattice: where samples are measured.
    """
    values = lattice.of(np.asarray(stack.dn[:HINT_FRAMES])).astype(np.float32)
    halves = [values[::2].mean(axis=0), values[1::2].mean(axis=0)]
    one, other = map(_above_surroundings, halves)
    middle = _above_surroundings(np.median(values, axis=0))
    spread = 1.4826 * float(np.median(np.abs(one)))
    threshold = STANDS_OUT * max(spread, float(np.sqrt(ROUNDING_DN2 / len(values[::2]))))
    least, most = (np.stack([one, other, middle]).min(axis=0), np.maximum(one, other))
    above = (least > threshold) & (most < ALIKE * least)
    return Leaks(
        where=above,
        excess_dn=(one + other)[above] / 2,
        threshold_dn=threshold,
        clipped=int((values[:, above].max(axis=0) >= stack.top_dn).sum()),
    )


def leaking(
    stack: Frames, lattices: Sequence[Lattice], gain_dn_per_e: dict[str, float]
) -> tuple[float, float, int] | None:
    """Share of samples that leak, how much in the mean in electrons, and how many tell it; None if
    they are too few.

    Args:
        stack: frames of one dark shot.
        lattices: where its measured samples are.
        gain_dn_per_e: by channel.
    """
    found = [(leaks_of(stack, one), gain_dn_per_e[one.channel]) for one in lattices]
    excess = np.concatenate([(one.excess_dn - one.threshold_dn) / gain for one, gain in found])
    number = len(excess) - sum(one.clipped for one, _ in found)
    if number < LEAST_NUMBER:
        return None
    mean = float(excess.sum()) / number
    counted = sum(
        one.where.size * float(np.exp(-one.threshold_dn / gain / mean)) for one, gain in found
    )
    return float(len(excess) / counted), mean, number


def _above_surroundings(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """An image less the median of the samples around each."""
    return np.asarray(image - cv2.medianBlur(np.ascontiguousarray(image), MEDIAN_OF))


def healed(stack: Frames, leaks: Sequence[tuple[Lattice, NDArray[np.bool_]]]) -> Frames:
    """Frames in which samples that leak are as their surroundings in each frame.

    Args:
        stack: frames of any shot.
        leaks: which samples of each lattice do.
    """
    dn = stack.dn.copy()
    for lattice, where in leaks:
        for frame in lattice.of(dn):
            around = cv2.medianBlur(np.ascontiguousarray(frame, dtype=np.float32), MEDIAN_OF)
            frame[where] = around[where].astype(dn.dtype)
    return dataclasses.replace(stack, dn=dn)
