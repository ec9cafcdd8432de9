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

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.hints import HINT_FRAMES, Told
from analysis.gap.ready.moments import gains_of
from analysis.gap.ready.setting import Setting
from sensor.frames import Frames
from sensor.thermal import DOUBLING_C, thermal_growth

STANDS_OUT = 8.0
"""Standard errors above its surroundings at which a sample leaks: no fixed pattern is as wide."""

ALIKE = 2.0
"""Times the excess of one half of the frames that the other one has at most, and that of the middle
one of all frames: a leak is as large in every frame, and flashes are not.
"""

LEAST_NUMBER = 4
"""Leaking samples that tell how many and how much: each to a half or better. Of 80 nulls of the
bench (seed 30) one has as many, 7, by its uneven dark current."""


def hot(setting: Setting) -> Told | None:
    """Density and rate of hot photosites; None where too few stand out of the longest dark.

    Args:
        setting: the capture.
    """
    darks = [s for s in setting.key_frames if s.shot.dark and s.shot.exposure_s > 0]
    if not darks:
        return None
    longest = max(darks, key=lambda stack: stack.shot.exposure_s)
    gain = gains_of(setting)
    found = leaking(longest, setting.scenery.view.lattices, gain)
    if found is None:
        return None
    density, excess_e, number = found
    growth = thermal_growth(longest.shot, DOUBLING_C)
    rate = excess_e / (growth * longest.shot.exposure_s)
    hints = {"density": density, "rate_e_per_s": rate}
    errors = {name: value / float(np.sqrt(number)) for name, value in hints.items()}
    return Told(hints=hints, errors=errors)


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
    beyond, thresholds, sizes = [], [], []
    clipped = 0
    for lattice in lattices:
        values = lattice.of(np.asarray(stack.dn[:HINT_FRAMES])).astype(np.float32)
        halves = [values[::2].mean(axis=0), values[1::2].mean(axis=0)]
        one, other = map(_above_surroundings, halves)
        middle = _above_surroundings(np.median(values, axis=0))
        spread = 1.4826 * float(np.median(np.abs(one)))
        threshold = STANDS_OUT * max(spread, float(np.sqrt(ROUNDING_DN2 / len(values[::2]))))
        gain = gain_dn_per_e[lattice.channel]
        least, most = (np.stack([one, other, middle]).min(axis=0), np.maximum(one, other))
        above = (least > threshold) & (most < ALIKE * least)
        beyond.append(((one + other)[above] / 2 - threshold) / gain)
        clipped += int((values[:, above].max(axis=0) >= stack.top_dn).sum())
        thresholds.append(threshold / gain)
        sizes.append(one.size)
    excess = np.concatenate(beyond)
    if len(excess) - clipped < LEAST_NUMBER:
        return None
    mean = float(excess.sum()) / (len(excess) - clipped)
    counted = np.array(sizes) @ np.exp(-np.array(thresholds) / mean)
    return float(len(excess) / counted), float(mean), len(excess) - clipped


def _above_surroundings(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """An image less the median of five by five samples around each."""
    return np.asarray(image - cv2.medianBlur(np.ascontiguousarray(image), 5))
