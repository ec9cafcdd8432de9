"""First figures of the base camera, by moments of the frames: where the fit begins.

variance in time = read + gain (mean - black)            photon transfer
mean             = black + gain level light exposure
pattern          = FPN + PRNU^2 (mean - black)^2
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.bias.rounding import ROUNDING_DN2
from analysis.gap.calibrate.darks import (
    GATHERED_DN,
    LEAST_READ_DN2,
    Darks,
    exposures_of,
    figure_of,
)
from analysis.gap.camera.base import MOST_DARK_E_PER_S, Base
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.light_blocks import blocks_of
from analysis.gap.camera.twin import NOT_CLIPPED, Scenery, exposure_of
from analysis.gap.look.arithmetic import IN_FRACTIONS
from analysis.gap.look.observation import Observation
from analysis.gap.look.statistics.structure import FRAME_SPREAD
from sensor.camera import Camera

Floats = NDArray[np.float64]

BELOW_FULL = 0.8
"""Part of the level of full photosites below which a block has none of them."""

USUAL_GAIN_DN_PER_E = 0.015
"""Of an 8-bit camera with 17 ke- full well; stands in where no light tells the gain."""

CLEAR_GROWTH = 5.0
"""Standard errors of the variance of darks that must gather as shot noise for it to tell a gain."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Full:
    """What is seen of full photosites, and of those beside them that are not.

    Attributes:
        levels_dn: level of full photosites by label of a lit shot that has some, (channels,); such
            a shot tells nothing of noise, and of its light what is well below.
        gain_dn_per_e: by samples that are well below, (channels,).
    """

    levels_dn: Mapping[str, Floats]
    gain_dn_per_e: Floats


def first_guess(
    seen: Observation,
    scenery: Scenery,
    nominal: Camera | None,
    dark: Darks,
    *,
    full: Full | None = None,
) -> Base:
    """A base by moments, of a camera that counts in fractions.

    Args:
        seen: the real capture.
        scenery: its light and shots.
        nominal: the camera that it is said to be; tells the gain where no light does.
        dark: what the darks show.
        full: what is known of full photosites, where there are any.
    """
    exposure = exposures_of(seen, scenery)
    mean = seen.means.mean(axis=(0, 3))
    levels_dn = full.levels_dn if full else {}
    lit = [k for k, label in enumerate(seen.shots) if label in seen.lit and label not in levels_dn]
    count = len(seen.channels)
    pattern = np.array(figure_of(seen, "pattern", "pattern variance"))
    noise = np.maximum(seen.noise - ROUNDING_DN2, LEAST_READ_DN2)
    fpn = dark.fpn_dn2
    signal = np.maximum(mean - dark.mean_dn(exposure), 0.0)
    if nominal is not None:
        gain = np.resize(np.array(list(nominal.gain_dn_per_e)), count)
    else:
        usual = USUAL_GAIN_DN_PER_E * 2.0 ** (_bits(scenery) - 8)
        longest_s = float(exposure.max())
        gain = np.full(count, usual) if lit else by_dark_current(seen, dark, longest_s, usual)
    tell = _clear(seen, lit, scenery.view.top_dn)
    if full:
        gain = full.gain_dn_per_e
    elif lit:
        shot_noise = (tell * (noise - dark.variance_dn2(exposure))).sum(axis=0)
        slope = shot_noise / np.maximum((tell * signal).sum(axis=0), 1e-6)
        gain = np.where(slope > 0.02 * gain, slope, gain)
    prnu = np.full(count, 1e-4)
    for c in range(count):
        if lit:
            by_shot = [
                pattern[k][c] * 1e-4 - fpn[c] / max(signal[k][c], 1) ** 2
                for k in np.flatnonzero(tell[:, c])
            ]
            prnu[c] = float(np.clip(np.median(by_shot), 1e-6, 0.01))
    base = Base(
        channels=seen.channels,
        gain_dn_per_e=gain,
        read_dn2=dark.read_dn2,
        fpn_dn2=dark.fpn_dn2,
        prnu2=prnu,
        black_dn=dark.black_dn,
        dark_e_per_s=_charge(dark.variance_dn2_per_s / gain**2, 0.0),
        shown_e_per_s=_charge(dark.mean_dn_per_s / gain, -MOST_DARK_E_PER_S),
        dark_spread2=dark_spread2(seen, exposure, dark, gain),
        dark_uneven=0.0,
        clamp_e2=0.0,
        arithmetic=IN_FRACTIONS,
        white_balance=None,
        blur_px2=0.0,
        level=levels(seen, scenery, dark, gain, levels_dn),
    )
    clamp = clamp_e2(seen, seen.noise / gain**2)
    # more is something else, and is not to be taken up in part
    return base if clamp > base.most_of_a_clamp_e2 else dataclasses.replace(base, clamp_e2=clamp)


def by_dark_current(seen: Observation, dark: Darks, longest_s: float, usual: float) -> Floats:
    """Gains, (channels,), where no light tells them: charge that gathers in the dark is the same
    behind every filter, and brings its shot noise. Of all channels the usual one where too little
    gathers, of green where its noise does not show it.

    Args:
        seen: darks.
        dark: what they show.
        longest_s: the longest exposure.
        usual: gain that stands in.
    """
    mean_dn, growth_dn2 = dark.mean_dn_per_s * longest_s, dark.variance_dn2_per_s * longest_s
    if mean_dn.min() < GATHERED_DN:
        return np.full(len(mean_dn), usual)
    over_first = mean_dn / mean_dn[0]
    freedom = seen.samples * seen.means.shape[-1] * seen.groups * (seen.frames - 1)
    error_dn2 = (dark.read_dn2 + growth_dn2) * np.sqrt(2.0 / freedom)
    green = seen.channels.index("G") if "G" in seen.channels else 0
    if growth_dn2.min() < CLEAR_GROWTH * error_dn2.max():
        return np.asarray(usual * over_first / over_first[green])
    return np.asarray(over_first * np.mean(growth_dn2 / mean_dn / over_first))


def _clear(seen: Observation, lit: Sequence[int], top_dn: int) -> NDArray[np.bool_]:
    """Which lit shots tell the noise of a channel, (shots, channels): what is clipped has none.
    Those without a clipped block, or all where there are no such.

    Args:
        seen: the capture.
        lit: places of the shots that are asked.
        top_dn: the largest pixel value.
    """
    asked = np.zeros((len(seen.shots), len(seen.channels)), dtype=bool)
    asked[list(lit)] = True
    clear = asked & (seen.means.mean(axis=0).max(axis=-1) < NOT_CLIPPED * top_dn)
    return np.where(clear.any(axis=0), clear, asked)


SPREADS = 2.0
"""Standard errors from which dark current is told to differ between photosites, or a clamp to have
noise. Where it is not, the figure stays 0 and is no direction of calibration."""


def dark_spread2(seen: Observation, exposure_s: Floats, dark: Darks, gain: Floats) -> float:
    """Variance of dark current over the photosites in e-^2/s^2, by the growth of the pattern from
    the shortest dark to the longest; 0 where it is lost in errors, or there is but one exposure.

    The product of the means of two halves of f frames has the variance, over n photosites,
    ((p + 2 s / f)^2 + p^2) / n, for a pattern of variance p and noise in time of variance s.

    Args:
        seen: the capture.
        exposure_s: of its shots.
        dark: what its darks show.
        gain: in DN/e-, (channels,).
    """
    darks = [k for k, label in enumerate(seen.shots) if label not in seen.lit]
    if len(darks) < 2:
        return 0.0
    ends = np.array([choose(exposure_s[darks]) for choose in (np.max, np.min)])[:, None]
    lever = float(ends[0, 0] ** 2 - ends[1, 0] ** 2)
    if lever <= 0:
        return 0.0
    size = seen.samples * seen.means.shape[-1]
    frames = seen.frames * seen.groups
    spread = dark.pattern_dn2_per_s2 / gain**2
    whole = np.maximum(dark.fpn_dn2 / gain**2 + spread * (np.square(ends) - ends[1] ** 2), 0.0)
    noise = (dark.read_dn2 + dark.variance_dn2_per_s * ends) / gain**2
    variance = (np.square(whole + 2 * noise / frames) + np.square(whole)).sum(axis=0)
    weight = size / variance
    grown = float(weight @ spread / weight.sum()) * lever
    return grown / lever if grown > SPREADS / float(np.sqrt(weight.sum())) else 0.0


def clamp_e2(seen: Observation, noise_e2: Floats) -> float:
    """Variance in e-^2 of what all pixels of a dark frame share; 0 where it is lost in errors.

    Means of frames differ by s^2 / n of n pixels with noise of variance s^2, and by the clamp's own
    noise c^2: half the mean square of the steps between f frames is their sum, over s^2 / n it has
    a standard error of sqrt(3 / (f - 1)) where there is no clamp.

    Args:
        seen: the capture.
        noise_e2: variance in time, (shots, channels).
    """
    told = [(k, key) for k, key in enumerate(seen.keys)
            if key.statistic == FRAME_SPREAD and key.shot not in seen.lit]  # fmt: skip
    lattices = Counter(lattice[0] for lattice in {key.lattice for _, key in told})
    found = []
    for k, key in told:
        channel = seen.channels.index(key.lattice[0])
        pixels = seen.samples * seen.means.shape[-1] / lattices[key.lattice[0]]
        mean_e2 = noise_e2[seen.shots.index(key.shot), channel] / pixels
        found.append((float(np.mean(seen.figures[:, k] ** 3)) - 1.0, float(mean_e2)))
    if not found:
        return 0.0
    beyond, mean_e2 = np.array(found).T
    error = np.sqrt(3.0 / ((seen.frames - 1) * seen.groups * len(found)))
    return float(np.mean(beyond * mean_e2)) if beyond.mean() > SPREADS * error else 0.0


def _charge(by_channel: Floats, least: float) -> float:
    """Electrons per second that all channels have in common."""
    return float(np.clip(by_channel.mean(), least, MOST_DARK_E_PER_S))


def levels(
    seen: Observation,
    scenery: Scenery,
    dark: Darks,
    gain: Floats,
    full_dn: Mapping[str, Floats],
) -> dict[str, Floats]:
    """Electrons per unit of light by lamp and channel, by least squares over the block means."""
    view = scenery.view
    light = {n: blocks_of(r, view, seen.channels) for n, r in scenery.light.rates.items()}
    found: dict[str, Floats] = {}
    for lamp in scenery.light.lamps:
        above, below = np.zeros(len(seen.channels)), np.zeros(len(seen.channels))
        for k, shot in enumerate(scenery.shots):
            if shot.dark or lamp_of(shot) != lamp:
                continue
            offset = dark.mean_dn(shot.exposure_s)
            for c in range(len(seen.channels)):
                y = seen.means[:, k, c].mean(axis=0)
                x = light[lamp][c] * exposure_of(shot)
                good = y < NOT_CLIPPED * view.top_dn
                if shot.label in full_dn:
                    room = BELOW_FULL * (full_dn[shot.label][c] - offset[c])
                    good &= _not_filled(x, y - offset[c], room)
                above[c] += float(x[good] @ (y[good] - offset[c]))
                below[c] += float(x[good] @ x[good])
        per_unit = np.where(below > 0, above / np.maximum(below, 1e-30), 1.0)
        found[lamp] = np.maximum(per_unit, 1e-12) / gain
    return found


DARKEST = 0.1
"""Part of the blocks, and of the ratios of those, that tell a level where photosites are full."""


def _not_filled(light: Floats, above_dn: Floats, room_dn: float) -> NDArray[np.bool_]:
    """Blocks as bright as their light makes them: what is full holds less, and what runs over from
    there makes others brighter. The darkest have nothing that is full, and of these the darkest
    for their light have been given nothing.

    Args:
        light: of each block.
        above_dn: how bright they are above black.
        room_dn: how bright a block may be, by its light, that has nothing full.
    """
    darkest = light <= np.quantile(light, DARKEST)
    ratio = above_dn / np.maximum(light, 1e-30)
    least = float(np.quantile(ratio[darkest], DARKEST))
    return (np.abs(ratio - least) < DARKEST * abs(least)) & (least * light < room_dn)


def _bits(scenery: Scenery) -> int:
    return int(np.log2(scenery.view.top_dn + 1))
