"""A power behind the converter, told by how brightness goes with the exposure.

What photosites collect grows as the exposure. Bent frames are straight again behind the inverse of
the curve, and only behind that: a block of the picture then has one rate whatever the exposure,

    u(m) - u(dark) = rate * exposure,    u(m) = o + R ((m - o) / R)^(1/g),

where m is the mean of its codes in one shot, and o where the curve begins. That no comb is needed
makes it the reading for converters of more bits than leave the camera, whose codes have none. The
response of cameras is calibrated so by Mitsunaga and Nayar (CVPR 1999), from exposures as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.camera.light import lamp_of
from analysis.gap.camera.twin import NOT_CLIPPED, exposure_of
from analysis.gap.look.curve import powered
from analysis.gap.look.lattices import channels_of
from analysis.gap.look.one_group import blocks
from analysis.gap.look.shots import HINT_FRAMES
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.setting import Setting
from sensor.frames import Frames

Floats = NDArray[np.float64]

EXPONENTS = np.round(np.arange(0.3, 2.505, 0.005), 4)
"""Powers that are tried."""

LIT = 0.05
"""Part of the range by which a block must be above the dark for its rate to be told."""

BENT = 0.015
"""Scatter of the logarithms of rates from which a camera is bent. Of 48 captures of five programs
without a curve 46 have 0.001 to 0.013, whatever is wrong with them."""

STRAIGHT = 0.25
"""Part of that scatter which is left at most behind the inverse of the right curve. Of those, 0.44
is the least; of the power 0.8 about code 0 it was 0.06."""

NEARLY = 0.02
"""Of an exponent from 1 within which a curve is none."""


@dataclass(frozen=True, kw_only=True)
class _Exposed:
    """Blocks under one lamp at one exposure times level: their means, and those of the dark, in
    DN.
    """

    exposure_s: float
    lit_dn: Floats
    dark_dn: Floats


def bent(setting: Setting) -> DirectReading | None:
    """The power of a curve behind which blocks go as the exposure, and where it begins: None where
    they go so without, or with none.

    Args:
        setting: the capture.
    """
    top_dn = float(setting.scenery.view.top_dn)
    exposed = list(_exposed(setting))

    def scatter(exponent: float, origin_dn: float) -> float:
        off = [_off(shots, top_dn, origin_dn, exponent) for shots in exposed]
        rates, weights = np.concatenate([np.zeros((2, 0)), *off], axis=1)
        # nothing is lit well enough, or at one exposure alone
        return float(np.sqrt(weights @ np.square(rates) / max(weights.sum(), 1.0)))

    as_it_is = scatter(1.0, 0.0)
    if as_it_is <= BENT:
        return None
    likelier = sorted(
        min((scatter(float(exponent), origin_dn), float(exponent), about) for exponent in EXPONENTS)
        for about, origin_dn in ((0.0, 0.0), (1.0, setting.black_dn))
    )
    told: DirectReading | None = None
    for left, exponent, about in reversed(likelier):
        if left < STRAIGHT * as_it_is and abs(exponent - 1.0) > NEARLY:
            told = DirectReading(
                hints={"exponent": exponent, "about_black": about}, exact=False, instead=told
            )
    return told


def _exposed(setting: Setting) -> Iterator[list[_Exposed]]:
    """Blocks of each lamp at each of its exposures, the longest one last; of lamps with several."""
    frames = setting.capture.frames
    darks = sorted((f for f in frames if f.shot.dark), key=lambda f: f.shot.exposure_s)
    if not darks:
        return
    means = {f.shot.label: _means(f, setting) for f in frames}
    at_s = [f.shot.exposure_s for f in darks]
    levels = np.array([means[f.shot.label].mean(axis=1) for f in darks])
    lit = [f for f in frames if not f.shot.dark and exposure_of(f.shot) > 0]
    for lamp in sorted({lamp_of(f.shot) for f in lit}):
        shots = sorted(
            (f for f in lit if lamp_of(f.shot) == lamp), key=lambda f: exposure_of(f.shot)
        )
        if len({exposure_of(f.shot) for f in shots}) < 2:
            continue
        yield [
            _Exposed(
                exposure_s=exposure_of(f.shot),
                lit_dn=means[f.shot.label],
                dark_dn=np.array([[np.interp(f.shot.exposure_s, at_s, one)] for one in levels.T]),
            )
            for f in shots
        ]


def _means(frames: Frames, setting: Setting) -> Floats:
    """Means of blocks by channel, (channels, blocks)."""
    view = setting.scenery.view
    dn = frames.dn[:HINT_FRAMES]
    of_lattice = [blocks(one.of(dn).mean(axis=0), view.side).ravel() for one in view.lattices]
    names = np.array([one.channel for one in view.lattices])
    images = np.array(of_lattice)
    return np.array([images[names == one].mean(axis=0) for one in channels_of(view.lattices)])


def _off(shots: list[_Exposed], top_dn: float, origin_dn: float, exponent: float) -> Floats:
    """Logarithms of the rates of blocks behind the inverse of a curve, less those at the longest
    exposure, and the weight of each, (2, n); of blocks that are lit and not full. Noise of a
    logarithm goes as 1 over what is lit.
    """

    def straight(dn: Floats) -> Floats:
        return powered(dn, top_dn, origin_dn, 1.0 / exponent)

    lit_dn = [one.lit_dn - one.dark_dn for one in shots]
    full = shots[-1].lit_dn > NOT_CLIPPED * top_dn
    good = (lit_dn[0] > LIT * top_dn) & ~full
    rates = [
        np.log((straight(one.lit_dn) - straight(one.dark_dn))[good] / one.exposure_s)
        for one in shots
    ]
    off = np.concatenate([one - rates[-1] for one in rates[:-1]])
    return np.array([off, np.square(np.concatenate([one[good] for one in lit_dn[:-1]]))])
