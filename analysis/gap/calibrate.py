"""First figures of the base camera, by moments of the frames: where the fit begins.

variance in time = read + gain (mean - black)            photon transfer
mean             = black + gain level light exposure
pattern          = FPN + PRNU^2 (mean - black)^2
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from analysis.bias.rounding import rounded
from analysis.gap.arithmetic import IN_FRACTIONS, OF_WHOLE_SAMPLES
from analysis.gap.base import MOST_DARK_E_PER_S, Base
from analysis.gap.light import lamp_of
from analysis.gap.light_blocks import blocks_of
from analysis.gap.observe import Observation
from analysis.gap.twin import Scenery, exposure_of
from sensor.camera import Camera
from sensor.effects.white_balance import WhiteBalance

Floats = NDArray[np.float64]

ROUNDING_DN2 = 1 / 12
LEAST_READ_DN2 = 0.01
USUAL_GAIN_DN_PER_E = 0.015
"""Of an 8-bit camera with 17 ke- full well; stands in where no light tells the gain."""


def black_of(means: Mapping[float, float], lit: Mapping[float, list[float]]) -> float:
    """Black level in DN: the shortest darks, or where the lit shots point to at no exposure.

    Args:
        means: mean of the darks by exposure.
        lit: means of the lit shots by exposure x level.
    """
    if means:
        return means[min(means)]
    if len(lit) > 1:
        x = np.array(list(lit))
        slope, intercept = np.polyfit(x, [float(np.mean(v)) for v in lit.values()], 1)
        return float(max(intercept, 0.0)) if slope > 0 else 0.0
    return 0.0


NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(15)
WEIGHTS = WEIGHTS / WEIGHTS.sum()


def behind_rounding(mean: float, in_time: float, pattern: float, top_dn: int) -> Floats:
    """Black level, read variance and FPN variance of darks, from what rounding to DN left of them.

    Offsets are normal over the pixels and noise is normal in time; their moments after rounding and
    clipping are sums, and the three figures are those that give the three that were seen.

    Args:
        mean, in_time, pattern: mean in DN, variance in time and between pixels in DN^2.
        top_dn: the largest pixel value.
    """

    def seen(figures: Floats) -> Floats:
        black, read, fpn = figures
        pixel = rounded(black + NODES * np.exp(fpn), np.exp(read), top_dn)
        average = float(WEIGHTS @ pixel.mean_dn)
        return np.array(
            [
                average - mean,
                np.log((WEIGHTS @ np.square(pixel.sd_dn) + 1e-4) / (in_time + 1e-4)),
                np.sqrt(WEIGHTS @ np.square(pixel.mean_dn - average)) - np.sqrt(max(pattern, 0.0)),
            ]
        )

    start = [mean, np.log(np.sqrt(max(in_time, 0.05))), np.log(0.1)]
    low = [mean - 1.0, np.log(0.02), np.log(0.003)]
    high = [mean + 1.0, np.log(0.5 * top_dn + 1), np.log(0.1 * top_dn + 1)]
    found = least_squares(seen, np.clip(start, low, high), bounds=(low, high)).x
    return np.array([found[0], np.exp(2 * found[1]), np.exp(2 * found[2])])


FAR_ENOUGH = 1.5
"""Longest over shortest exposure of darks from which a line through them is drawn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Darks:
    """What the darks show, as lines over the exposure; all per channel.

    Attributes:
        black_dn, mean_dn_per_s: of the mean.
        read_dn2, variance_dn2_per_s: of the variance in time, without that of rounding.
        fpn_dn2: variance of the fixed offsets.
    """

    black_dn: Floats
    mean_dn_per_s: Floats
    read_dn2: Floats
    variance_dn2_per_s: Floats
    fpn_dn2: Floats

    def mean_dn(self, exposure_s: Floats | float) -> Floats:
        """Of dark frames of an exposure, or of several: (n, channels)."""
        return np.asarray(self.black_dn + self.mean_dn_per_s * np.asarray(exposure_s)[..., None])

    def variance_dn2(self, exposure_s: Floats | float) -> Floats:
        """In time, of dark frames of an exposure, or of several: (n, channels)."""
        growth = self.variance_dn2_per_s * np.asarray(exposure_s)[..., None]
        return np.asarray(self.read_dn2 + growth)

    @staticmethod
    def none(count: int, black_dn: float, read_dn2: float) -> Darks:
        """Where there are none: for so many channels, by what the lit shots let guess."""
        zero = np.zeros(count)
        return Darks(
            black_dn=zero + black_dn,
            mean_dn_per_s=zero,
            read_dn2=zero + read_dn2,
            variance_dn2_per_s=zero,
            fpn_dn2=zero + 0.01,
        )

    @staticmethod
    def of(
        exposure_s: Floats, mean_dn: Floats, in_time_dn2: Floats, pattern_dn2: Floats, top_dn: int
    ) -> Darks:
        """The lines through some darks.

        Args:
            exposure_s: (shots,).
            mean_dn, in_time_dn2, pattern_dn2: of each, (shots, channels).
            top_dn: the largest pixel value.
        """
        seen = np.array([
            [behind_rounding(*figures, top_dn) for figures in zip(*shot, strict=True)]
            for shot in zip(mean_dn, in_time_dn2, pattern_dn2, strict=True)
        ])  # fmt: skip
        first, last = int(np.argmin(exposure_s)), int(np.argmax(exposure_s))
        black, read, fpn = seen[first].T
        slope, growth = np.zeros_like(black), np.zeros_like(read)
        if exposure_s[last] > FAR_ENOUGH * exposure_s[first]:
            slope, growth, _ = (seen[last] - seen[first]).T / (exposure_s[last] - exposure_s[first])
        growth = np.clip(growth, 0.0, 0.9 * read / max(float(exposure_s[first]), 1e-9))
        return Darks(
            black_dn=black - slope * exposure_s[first],
            mean_dn_per_s=slope,
            read_dn2=read - growth * exposure_s[first],
            variance_dn2_per_s=growth,
            fpn_dn2=fpn,
        )


def darks_of(seen: Observation, scenery: Scenery, black_dn: float) -> Darks:
    """What the darks of a capture show.

    Args:
        seen: the real capture.
        scenery: its light and shots.
        black_dn: black level, where there are none.
    """
    darks = [k for k, label in enumerate(seen.shots) if label not in seen.lit]
    if not darks:
        noise = max(float(seen.noise.min()) - ROUNDING_DN2, LEAST_READ_DN2)
        return Darks.none(len(seen.channels), black_dn, max(0.05, 0.3 * noise))
    return Darks.of(
        _exposures(seen, scenery)[darks],
        seen.means.mean(axis=(0, 3))[darks],
        seen.noise[darks],
        np.array(_figure(seen, "pattern", "pattern variance"))[darks],
        scenery.view.top_dn,
    )


def _exposures(seen: Observation, scenery: Scenery) -> Floats:
    by_label = {shot.label: shot.exposure_s for shot in scenery.shots}
    return np.array([by_label[label] for label in seen.shots])


def first_guess(
    seen: Observation,
    scenery: Scenery,
    nominal: Camera | None,
    black_dn: float,
    arithmetic: int = IN_FRACTIONS,
) -> Base:
    """A base by moments.

    Args:
        seen: the real capture.
        scenery: its light and shots.
        nominal: the camera that it is said to be; tells the gain where no light does.
        black_dn: black level.
        arithmetic: of the demosaicer.
    """
    dark = darks_of(seen, scenery, black_dn)
    exposure = _exposures(seen, scenery)
    mean = seen.means.mean(axis=(0, 3))
    lit = [k for k, label in enumerate(seen.shots) if label in seen.lit]
    count = len(seen.channels)
    pattern = np.array(_figure(seen, "pattern", "pattern variance"))
    noise = np.maximum(seen.noise - ROUNDING_DN2, LEAST_READ_DN2)
    fpn = dark.fpn_dn2
    signal = np.maximum(mean - dark.mean_dn(exposure), 0.0)
    if nominal is not None:
        gain = np.resize(np.array(list(nominal.gain_dn_per_e)), count)
    else:
        gain = np.full(count, USUAL_GAIN_DN_PER_E * 2.0 ** (_bits(scenery) - 8))
    if lit:
        shot_noise = (noise - dark.variance_dn2(exposure))[lit].sum(axis=0)
        slope = shot_noise / np.maximum(signal[lit].sum(axis=0), 1e-6)
        gain = np.where(slope > 0.02 * gain, slope, gain)
    prnu = np.full(count, 1e-4)
    for c in range(count):
        if lit:
            by_shot = [pattern[k][c] * 1e-4 - fpn[c] / max(signal[k][c], 1) ** 2 for k in lit]
            prnu[c] = float(np.clip(np.median(by_shot), 1e-6, 0.01))
    return Base(
        channels=seen.channels,
        gain_dn_per_e=gain,
        read_dn2=dark.read_dn2,
        fpn_dn2=dark.fpn_dn2,
        prnu2=prnu,
        black_dn=dark.black_dn,
        dark_e_per_s=_charge(dark.variance_dn2_per_s / gain**2, 0.0),
        shown_e_per_s=_charge(dark.mean_dn_per_s / gain, -MOST_DARK_E_PER_S),
        arithmetic=arithmetic,
        white_balance=None,
        blur_px2=0.0,
        level=levels(seen, scenery, dark, gain),
    )


def before(balance: WhiteBalance, base: Base) -> Base:
    """The base in front of a white balance, of one that was read behind it.

    Args:
        balance: gains of whole codes.
        base: by moments of the frames.
    """
    k = np.array(
        [{"R": balance.red_gain, "B": balance.blue_gain}.get(c, 1.0) for c in base.channels]
    )
    origin = float(base.black_dn.mean()) if balance.about_black else 0.0
    return dataclasses.replace(
        base,
        gain_dn_per_e=base.gain_dn_per_e / k,
        read_dn2=base.read_dn2 / k**2,
        fpn_dn2=base.fpn_dn2 / k**2,
        black_dn=origin + (base.black_dn - origin) / k,
        arithmetic=OF_WHOLE_SAMPLES,
        white_balance=balance,
    )


def _charge(by_channel: Floats, least: float) -> float:
    """Electrons per second that all channels have in common."""
    return float(np.clip(by_channel.mean(), least, MOST_DARK_E_PER_S))


def levels(seen: Observation, scenery: Scenery, dark: Darks, gain: Floats) -> dict[str, Floats]:
    """Electrons per unit of light by lamp and channel, by least squares over the block means."""
    view = scenery.view
    light = {n: blocks_of(r, view, seen.channels) for n, r in scenery.light.rates.items()}
    top = view.top_dn
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
                good = y < 0.97 * top
                above[c] += float(x[good] @ (y[good] - offset[c]))
                below[c] += float(x[good] @ x[good])
        per_unit = np.where(below > 0, above / np.maximum(below, 1e-30), 1.0)
        found[lamp] = np.maximum(per_unit, 1e-12) / gain
    return found


def _figure(seen: Observation, family: str, statistic: str) -> list[Floats]:
    """A statistic by shot, each per channel; 0 where a shot has none."""
    total = np.zeros((len(seen.shots), len(seen.channels)))
    number = np.zeros_like(total)
    for key, value in zip(seen.keys, seen.figures.mean(axis=0), strict=True):
        if (key.family, key.statistic) == (family, statistic):
            where = seen.shots.index(key.shot), seen.channels.index(key.lattice[0])
            total[where] += value
            number[where] += 1
    return list(total / np.maximum(number, 1))


def _bits(scenery: Scenery) -> int:
    return int(np.log2(scenery.view.top_dn + 1))
