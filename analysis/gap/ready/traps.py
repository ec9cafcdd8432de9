"""How many photosites jump between two levels, how far, and how long they stay on each.

A pixel that jumps by many times its noise shows its level in every frame, and the frames of all of
them are one Markov chain of two states. With p the share of frames on the upper level and a what is
left of a level after one frame, it goes

    up to up  p + (1 - p) a        down to down  1 - p + p a

Only pixels that were seen on both levels count, so that the likelihood of a sequence is divided by
the chance of that. Jumps are exponential and forget, as in `hot`: beyond a threshold t they have
the same mean m again, and the share of photosites is

    number / (photosites exp(-t / m) chance of both levels)

A fit by twins cannot do as well: a few dozen pixels of theirs jump, others and at other times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from analysis.gap.look.lattices import Lattice
from analysis.gap.ready.hints import FEWEST_OF_A_DWELL, Told
from analysis.gap.ready.moments import gains_of
from analysis.gap.ready.setting import Setting
from sensor.frame_times import interval_of
from sensor.frames import Frames

Floats = NDArray[np.float64]

FAR = 8.0
"""Standard errors of one frame by which the two levels of a pixel differ at least."""

NARROW = 2.0
"""The same that the frames of one level scatter by at most."""

LEAST_NUMBER = 16
"""Pixels of one shot that tell it, each figure to about a quarter."""

LEAST_JUMPS = 16
"""Jumps each way."""

LEAST_STAY = 0.05
"""What is left of a level after one frame: less is noise of another kind."""

SOME = 8
"""Every so many pixels tell the noise of the typical one."""

LEAST_NOISE_DN = 0.3
"""Of a frame, from its rounding: less is not believed."""


@dataclass(frozen=True, kw_only=True)
class Jumps:
    """What the jumping pixels of one dark shot show.

    Attributes:
        beyond_e: by how much each jumps beyond the threshold, in electrons.
        thresholds: of each lattice in electrons, and the number of its samples.
        counts: frames from level (row) to level (column), 0 down and 1 up.
        first: pixels that begin on each level.
        frames: of the shot.
        interval_s: from frame to frame.
    """

    beyond_e: Floats
    thresholds: tuple[tuple[float, int], ...]
    counts: Floats
    first: Floats
    frames: int
    interval_s: float


def trapped(setting: Setting) -> Told | None:
    """Share of photosites with a trap, amplitude and dwell times; None where too few jump far.

    Args:
        setting: the capture.
    """
    darks = [s for s in setting.key_frames if s.shot.dark and s.count >= FEWEST_OF_A_DWELL]
    if not darks:
        return None
    gain = gains_of(setting)
    shots = [jumps(stack, setting.scenery.view.lattices, gain) for stack in darks]
    return told_by_jumps(shots)


def told_by_jumps(shots: Sequence[Jumps]) -> Told | None:
    """The same of what several dark shots of one body show.

    Args:
        shots: of equal intervals.
    """
    number = np.array([len(shot.beyond_e) for shot in shots])
    counts = np.sum([shot.counts for shot in shots], axis=0)
    if number.max() < LEAST_NUMBER or min(counts[0, 1], counts[1, 0]) < LEAST_JUMPS:
        return None
    share_up, stays = _chain(shots)
    if stays < LEAST_STAY:
        return None
    tau_s = -shots[0].interval_s / np.log(stays)
    dwell_up_s, dwell_down_s = tau_s / (1.0 - share_up), tau_s / share_up
    amplitude_e = float(np.concatenate([shot.beyond_e for shot in shots]).mean())
    expected = sum(
        samples * np.exp(-threshold / amplitude_e) * _both(shot.frames, share_up, stays)
        for shot in shots
        for threshold, samples in shot.thresholds
    )
    hints = {
        "fraction": float(number.sum() / expected),
        "amplitude_e": amplitude_e,
        "dwell_up_s": float(dwell_up_s),
        "dwell_down_s": float(dwell_down_s),
    }
    # the same pixels jump in every shot, and each of their jumps is one more
    of = {
        "fraction": number.max(),
        "amplitude_e": number.max(),
        "dwell_up_s": counts[1, 0],
        "dwell_down_s": counts[0, 1],
    }
    errors = {name: value / float(np.sqrt(of[name])) for name, value in hints.items()}
    return Told(hints=hints, errors=errors)


def jumps(stack: Frames, lattices: Sequence[Lattice], gain_dn_per_e: dict[str, float]) -> Jumps:
    """The pixels of a dark shot that have two levels, far apart, and nothing between.

    Args:
        stack: its frames.
        lattices: where its measured samples are.
        gain_dn_per_e: by channel.
    """
    beyond, thresholds = [], []
    counts, first = np.zeros((2, 2)), np.zeros(2)
    for lattice in lattices:
        dn = lattice.of(stack.dn)
        dn = dn.reshape(len(dn), -1)
        typical = dn[:, ::SOME].astype(np.float32).var(axis=0, ddof=1)
        noise = max(float(np.sqrt(np.median(typical))), LEAST_NOISE_DN)
        top, bottom = dn.max(axis=0).astype(np.float32), dn.min(axis=0).astype(np.float32)
        wide = top - bottom > FAR * noise
        values = dn[:, wide].astype(np.float32)
        up = values > (top + bottom)[wide] / 2
        high = np.where(up, values, 0.0).sum(axis=0) / up.sum(axis=0)
        low = np.where(up, 0.0, values).sum(axis=0) / (~up).sum(axis=0)
        scatter = np.sqrt(np.square(values - np.where(up, high, low)).mean(axis=0))
        far = (high - low > FAR * noise) & (scatter < NARROW * noise)
        gain = gain_dn_per_e[lattice.channel]
        beyond.append(((high - low)[far] - FAR * noise) / gain)
        thresholds.append((FAR * noise / gain, dn.shape[1]))
        states = up[:, far].astype(int)
        np.add.at(counts, (states[:-1].ravel(), states[1:].ravel()), 1.0)
        np.add.at(first, states[0], 1.0)
    return Jumps(
        beyond_e=np.concatenate(beyond).astype(np.float64),
        thresholds=tuple(thresholds),
        counts=counts,
        first=first,
        frames=stack.count,
        interval_s=interval_of(stack.shot),
    )


def _chain(shots: Sequence[Jumps]) -> tuple[float, float]:
    """Share of the upper level, and what is left of a level after a frame, by likelihood."""

    def surprise(at: Floats) -> float:
        share_up, stays = 1.0 / (1.0 + np.exp(-at))
        there = np.array([1.0 - share_up, share_up])
        moves = stays * np.eye(2) + (1.0 - stays) * there
        total = 0.0
        for shot in shots:
            total -= float((shot.counts * np.log(moves)).sum() + shot.first @ np.log(there))
            both = _both(shot.frames, share_up, stays)
            total += len(shot.beyond_e) * float(np.log(both))
        return total

    found = optimize.minimize(surprise, np.zeros(2), method="Nelder-Mead")
    share_up, stays = 1.0 / (1.0 + np.exp(-found.x))
    return float(share_up), float(stays)


def _both(frames: int, share_up: float, stays: float) -> float:
    """Chance that a pixel is seen on both levels."""
    up = share_up * (share_up + (1.0 - share_up) * stays) ** (frames - 1)
    down = (1.0 - share_up) * (1.0 - share_up + share_up * stays) ** (frames - 1)
    return float(1.0 - up - down)
