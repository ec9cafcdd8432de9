"""What the frames themselves say of parameters that no search could guess: a frequency, a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.base import Base
from analysis.gap.camera.twin import Scenery
from analysis.gap.look.lattices import Lattice
from analysis.gap.look.shots import HINT_FRAMES
from sensor.colours import Colours
from sensor.frame_times import interval_of
from sensor.frames import Frames

Floats = NDArray[np.float64]

Hints = Mapping[str, float | Colours]
"""Where a search for a parameter of that name should begin."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DirectReading:
    """What the frames tell of a suspect's parameters without a fit; it is followed in any case.

    Attributes:
        hints: the parameters.
        exact: whether they are told to the last digit: no fit is better.
        base: where the camera begins with it, if that is better known than what fits without.
        instead: the same told otherwise, for where these parameters leave something.
        scenery: under which light; None under the light as it shows to the camera without it.
        errors: standard errors of those that the frames tell with more than the last digit.
    """

    hints: Hints
    exact: bool = True
    base: Base | None = None
    instead: DirectReading | None = None
    scenery: Scenery | None = None
    errors: Mapping[str, float] = field(default_factory=dict)


LOUD = 0.005
"""Part of the pixels that are noisiest, of which the time constant is read."""

FEWEST_OF_A_DWELL = 12
"""Frames of a dark from which it is read."""

LEAST_CORRELATION = 0.05
"""Of a frame with the next, in what these pixels have beyond others: less is chance."""


def dwell_s(stacks: Sequence[Frames], lattices: tuple[Lattice, ...]) -> float | None:
    """Dwell time of a level of the noisiest pixels, if both are equally long; None of noise alone.

    A trap's noise is correlated over k frames by exp(-k interval / tau), and tau is half of the
    dwell time. Pixels are chosen by every other pair of frames and read in those between, so that
    chance does not choose what it then reads; the noise of the typical pixel is taken off.
    """
    of_next = of_same = 0.0
    for stack in stacks:
        if not stack.shot.dark or stack.count < FEWEST_OF_A_DWELL:
            continue
        for lattice in lattices:
            noise = lattice.of(stack.dn[:BEATS_FRAMES]).astype(np.float64)
            noise = noise - noise.mean(axis=0)
            pairs = noise[: len(noise) // 4 * 4].reshape(-1, 2, 2, *noise.shape[1:])
            choosing, reading = pairs[:, 0], pairs[:, 1]
            power = np.square(choosing).mean(axis=(0, 1))
            loud = power > np.quantile(power, 1 - LOUD)
            same = np.square(reading).mean(axis=(0, 1))
            following = reading.prod(axis=1).mean(axis=0)
            of_same += float((same[loud] - np.median(same)).sum())
            of_next += float((following[loud] - np.median(following)).sum())
            interval_s = interval_of(stack.shot)
    if of_same <= 0 or not LEAST_CORRELATION < of_next / of_same < 1:
        return None
    return float(-2.0 * interval_s / np.log(of_next / of_same))


MAINS_HZ = np.arange(45.0, 65.0, 0.02)
"""Frequencies of the mains that are tried."""

USUAL_MAINS_HZ = (50.0, 60.0)
"""Of frequencies that beat alike the nearest to one of these is taken."""

RIPPLE = 2.0 / 3.0
"""Amplitude at twice the mains of a rectified sine, relative to its mean."""

BEATS_FRAMES = 64
"""Frames of a shot whose means are looked at."""

CLEAR_BEAT = 8.0
"""Power of a beat in the means of frames over the typical one; of noise the highest has 5."""

AS_GOOD = 0.97
"""Part of the power from which another frequency of the mains shows as well: the same beat comes
from many."""


def mains_hz(stacks: Sequence[Frames]) -> float | None:
    """Frequency of the mains whose light beats with the frames as their means do; None without.

    Of those that beat alike it is the one next to 50 or 60 Hz of which a lamp can beat as deeply:
    an exposure of n half cycles leaves sinc n of its ripple, nothing of whole ones.
    """
    power, depth = np.zeros((2, len(MAINS_HZ)))
    for stack in stacks:
        if stack.shot.dark:
            continue
        dn = np.asarray(stack.dn[:BEATS_FRAMES, ::4, ::4], dtype=np.float64)
        means = dn.reshape(len(dn), -1).mean(axis=1)
        beat = means / max(means.mean(), 1e-9) - 1.0
        starts_s = np.arange(len(dn)) * interval_of(stack.shot)
        waves = np.exp(-2j * np.pi * 2 * np.outer(MAINS_HZ, starts_s))
        along = np.abs(waves @ beat)
        power += np.square(along) / max(float(beat @ beat), 1e-30)
        at_most = RIPPLE * np.abs(np.sinc(2 * MAINS_HZ * stack.shot.exposure_s))
        depth = np.maximum(depth, 2 * along / len(dn) / np.maximum(at_most, 1e-9))
    highest = float(power.max())
    if highest < CLEAR_BEAT * float(np.median(power)) or highest == 0:
        return None
    as_good = power > AS_GOOD * highest
    possible = as_good & (depth <= 1.0)
    alike = MAINS_HZ[possible if possible.any() else as_good]
    off = np.abs(alike[:, None] - np.array(USUAL_MAINS_HZ)).min(axis=1)
    return float(alike[np.argmin(off)])


MOST_BITS = 8
"""Lowest bits that may be lost, as of `BitTruncation`."""


def empty_bits(stacks: Sequence[Frames], lattices: Sequence[Lattice]) -> int:
    """Lowest bits that have one value in all measured samples: nothing was ever counted in them.

    The first and the last code are no witnesses: all that is beyond them is clipped there. Of
    colours green alone tells, which a white balance leaves as it was.
    """
    asked = [lattice for lattice in lattices if lattice.channel == "G"] or lattices
    codes = [np.unique(one.of(stack.dn[:HINT_FRAMES])) for stack in stacks for one in asked]
    used = np.unique(np.concatenate(codes)).astype(np.int64)
    used = used[(used > 0) & (used < stacks[0].top_dn)]
    for bits in range(MOST_BITS, 0, -1):
        if len(used) > 1 and len(np.unique(used % 2**bits)) == 1:
            return bits
    return 0
