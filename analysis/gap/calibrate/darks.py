"""What darks show of a camera: black level, read noise, fixed offsets, and what grows with time.

Below half a code of noise all of them are behind rounding. A dark then shows two codes, and their
shares tell only where the black level is in units of the noise: either light or a third code has to
tell the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from analysis.bias.rounding import ROUNDING_DN2, rounded
from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.twin import Scenery, exposure_of
from analysis.gap.look.observation import Observation

Floats = NDArray[np.float64]

LEAST_READ_DN2 = 0.01
"""Least variance of read noise that a first camera is given, in DN^2: never none, nor less."""


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
"""Gauss-Hermite points over a normal distribution of variance 1, and weights whose sum is 1."""


TOLD_TO_DN = 0.002
"""By how much a black level that is told may be moved: where two codes share a dark, a hundredth in
its black level is a fifth in its noise."""


def behind_rounding(
    mean: float, in_time: float, pattern: float, top_dn: int, black_dn: float | None = None
) -> Floats:
    """Black level, read variance and FPN variance of darks, from what rounding to DN left of them.

    Offsets are normal over the pixels and noise is normal in time; their moments after rounding and
    clipping are sums, and the three figures are those that give the three that were seen.

    Args:
        mean, in_time, pattern: mean in DN, variance in time and between pixels in DN^2.
        top_dn: the largest pixel value.
        black_dn: black level, where something else tells it.
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

    middle, width = (mean, 1.0) if black_dn is None else (black_dn, TOLD_TO_DN)
    start = [middle, np.log(np.sqrt(max(in_time, 0.05))), np.log(0.1)]
    low = [middle - width, np.log(0.02), np.log(0.003)]
    high = [middle + width, np.log(0.5 * top_dn + 1), np.log(0.1 * top_dn + 1)]
    found = least_squares(seen, np.clip(start, low, high), bounds=(low, high)).x
    return np.array([found[0], np.exp(2 * found[1]), np.exp(2 * found[2])])


ROUNDED_DN = 0.5
"""Read noise and offsets together below which darks are behind rounding."""

UNSATURATED = 0.9
"""Part of the range below which a block is used to point to the black level."""

GATHERED_DN = 1.0
"""What the longest dark gathers in every colour, from which darks tell gains of colours."""

FAR_ENOUGH = 1.5
"""Longest over shortest exposure of darks from which a line through them is drawn."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Darks:
    """What the darks show, as lines over the exposure; all per channel.

    Attributes:
        black_dn, mean_dn_per_s: of the mean.
        read_dn2, variance_dn2_per_s: of the variance in time, without that of rounding.
        fpn_dn2: variance of the fixed offsets.
        pattern_dn2_per_s2: of the pattern's variance over the square of the exposure.
    """

    black_dn: Floats
    mean_dn_per_s: Floats
    read_dn2: Floats
    variance_dn2_per_s: Floats
    fpn_dn2: Floats
    pattern_dn2_per_s2: Floats

    def mean_dn(self, exposure_s: Floats | float) -> Floats:
        """Of dark frames of an exposure, or of several: (n, channels)."""
        return np.asarray(self.black_dn + self.mean_dn_per_s * np.asarray(exposure_s)[..., None])

    def variance_dn2(self, exposure_s: Floats | float) -> Floats:
        """In time, of dark frames of an exposure, or of several: (n, channels)."""
        growth = self.variance_dn2_per_s * np.asarray(exposure_s)[..., None]
        return np.asarray(self.read_dn2 + growth)

    @property
    def quiet(self) -> bool:
        """Whether moments do not tell how much noise there is, of the quietest channel."""
        return float(np.sqrt(np.min(self.read_dn2 + self.fpn_dn2))) < ROUNDED_DN

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
            pattern_dn2_per_s2=zero,
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
        slope, growth, spread = np.zeros_like(black), np.zeros_like(read), np.zeros_like(fpn)
        if exposure_s[last] > FAR_ENOUGH * exposure_s[first]:
            slope, growth, spread = (seen[last] - seen[first]).T / np.array(
                [[exposure_s[last] ** n - exposure_s[first] ** n] for n in (1, 1, 2)]
            )
        growth = np.clip(growth, 0.0, 0.9 * read / max(float(exposure_s[first]), 1e-9))
        return Darks(
            black_dn=black - slope * exposure_s[first],
            mean_dn_per_s=slope,
            read_dn2=read - growth * exposure_s[first],
            variance_dn2_per_s=growth,
            fpn_dn2=fpn,
            pattern_dn2_per_s2=spread,
        )


def darks_of(seen: Observation, scenery: Scenery, black_dn: float) -> Darks:
    """What the darks of a capture show.

    Args:
        seen: the real capture.
        scenery: its light and shots.
        black_dn: black level, where there are none.
    """
    if len(seen.lit) == len(seen.shots):
        noise = max(float(seen.noise.min()) - ROUNDING_DN2, LEAST_READ_DN2)
        return Darks.none(len(seen.channels), black_dn, max(0.05, 0.3 * noise))
    return Darks.of(*_of_darks(seen, scenery), scenery.view.top_dn)


def darks_by_light(seen: Observation, scenery: Scenery) -> Darks | None:
    """What the darks show if the black level is that to which lit shots point, and without dark
    current: noise and offsets in DN^2 of the shortest dark, per channel.

    None where there are no darks, or no lit shots to draw a line through.
    """
    black_dn = black_by_light(seen, scenery)
    if black_dn is None or len(seen.lit) == len(seen.shots):
        return None
    exposure_s, *moments = _of_darks(seen, scenery)
    first, top_dn = int(np.argmin(exposure_s)), scenery.view.top_dn
    by_channel = zip(*(figures[first] for figures in moments), black_dn, strict=True)
    found = [
        behind_rounding(mean, in_time, pattern, top_dn, black)
        for mean, in_time, pattern, black in by_channel
    ]
    black, read, fpn = np.array(found).T
    zero = np.zeros_like(black)
    return Darks(
        black_dn=black,
        mean_dn_per_s=zero,
        read_dn2=read,
        variance_dn2_per_s=zero,
        fpn_dn2=fpn,
        pattern_dn2_per_s2=zero,
    )


def black_by_light(seen: Observation, scenery: Scenery) -> Floats | None:
    """Black level per channel in DN, where lit shots of one lamp point to without light.

    Noise carries their means over the steps of the converter. None where no lamp has two levels.
    """
    of_lamp: dict[str, list[int]] = {}
    for k, shot in enumerate(scenery.shots):
        if not shot.dark:
            of_lamp.setdefault(lamp_of(shot), []).append(k)
    exposure = np.array([exposure_of(shot) for shot in scenery.shots])
    mean = seen.means.mean(axis=0)
    found = []
    for shots in of_lamp.values():
        if len(set(exposure[shots])) < 2:
            continue
        good = (mean[shots] < UNSATURATED * scenery.view.top_dn).all(axis=(0, 1))
        if good.any():
            line = np.polyfit(exposure[shots], mean[shots][..., good].mean(axis=2), 1)
            found.append(line[1])
    return np.mean(found, axis=0) if found else None


def _of_darks(seen: Observation, scenery: Scenery) -> tuple[Floats, Floats, Floats, Floats]:
    """Exposures in s, (shots,), means in DN and variances in time and of the pattern in DN^2."""
    darks = [k for k, label in enumerate(seen.shots) if label not in seen.lit]
    return (
        exposures_of(seen, scenery)[darks],
        seen.means.mean(axis=(0, 3))[darks],
        seen.noise[darks],
        np.array(figure_of(seen, "pattern", "pattern variance"))[darks],
    )


def exposures_of(seen: Observation, scenery: Scenery) -> Floats:
    """Exposure of each shot that was seen, in s, (shots,)."""
    by_label = {shot.label: shot.exposure_s for shot in scenery.shots}
    return np.array([by_label[label] for label in seen.shots])


def figure_of(seen: Observation, family: str, statistic: str) -> list[Floats]:
    """A statistic by shot, each per channel; 0 where a shot has none."""
    total = np.zeros((len(seen.shots), len(seen.channels)))
    number = np.zeros_like(total)
    for key, value in zip(seen.keys, seen.figures.mean(axis=0), strict=True):
        if (key.family, key.statistic) == (family, statistic):
            where = seen.shots.index(key.shot), seen.channels.index(key.lattice[0])
            total[where] += value
            number[where] += 1
    return list(total / np.maximum(number, 1))
