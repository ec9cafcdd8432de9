"""What light is like within pixels, as one picture shows it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from analysis.gap.camera.blur import Blur, Within, softened
from analysis.gap.camera.light import Light, Rate, lamp_of
from analysis.gap.camera.light_of_frames import CLEAR_OF_THE_TOP, picture
from analysis.gap.look.lattices import Lattice
from sensor.frames import Frames

Floats = NDArray[np.float64]

LARGEST_PX = (240, 320)
"""Rows and columns in the middle of a picture that are looked at: they tell by hundreds."""

LEAST_CLEAR = 0.97
"""Part of a picture that has to be so."""

SIGMAS_PX = (0.1, 2.0)
"""Blurs among which the likeliest is looked for, as standard deviations."""

CLOSE_PX = 0.01
"""Standard deviation to which it is found."""

MOST_EVEN = 0.6
FEWEST_EVEN = 0.9
"""Parts of the samples, by how steep the picture is, up to which they are even, and from which they
lie at edges."""

LEAST_DN2 = 1e-9
"""Variance of what is left of a picture without any noise, for logarithms and quotients of it."""

MOST_SIGMAS = 5.0
"""By which a sample counts at most: hot ones are beside the point."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A picture and the light that made it.

    Attributes:
        dn: samples of each lattice, (h, w).
        rate: light of its colour, (H, W) each.
        lattices: where samples were measured.
        top_dn: up to which they tell how bright it is.
    """

    dn: tuple[Floats, ...]
    rate: Rate
    lattices: tuple[Lattice, ...]
    top_dn: float


@dataclass(frozen=True, kw_only=True)
class Likeliest:
    """The likeliest blur over light of one kind.

    Attributes:
        blur: which.
        log_likelihood: of the picture, up to a constant.
        at_edges: mean square of what is left there, in standard deviations of what is left where
            the picture is even: 1 where the light is right.
    """

    blur: Blur
    log_likelihood: float
    at_edges: float


def picture_of(
    frames: Sequence[Frames], light: Light, lattices: Sequence[Lattice]
) -> Picture | None:
    """The brightest picture that is not clipped; None where all are.

    Args:
        frames: of all shots.
        light: that is known.
        lattices: where samples were measured.
    """
    best: tuple[float, NDArray[np.float32], Frames] | None = None
    for one in frames:
        if one.shot.dark or lamp_of(one.shot) not in light.falls:
            continue
        mean = picture(one)
        bright, clear = float(mean.mean()), (mean < CLEAR_OF_THE_TOP * one.top_dn).mean()
        if clear > LEAST_CLEAR and (best is None or bright > best[0]):
            best = bright, mean, one
    if best is None:
        return None
    _, mean, shown = best
    rate = light.falls[lamp_of(shown.shot)]
    middle = _middle(mean.shape[0], mean.shape[1])
    return Picture(
        dn=tuple(one.of(mean[middle][None])[0].astype(np.float64) for one in lattices),
        rate=rate[middle],
        lattices=tuple(lattices),
        top_dn=CLEAR_OF_THE_TOP * shown.top_dn,
    )


def _middle(height: int, width: int) -> tuple[slice, slice]:
    """The middle of a picture, in the phase of its mosaic."""
    (rows, down), (columns, across) = (
        (min(size, most), max(0, size - most) // 4 * 2)
        for size, most in zip((height, width), LARGEST_PX, strict=True)
    )
    return slice(down, down + rows), slice(across, across + columns)


def likeliest(shown: Picture, within: Within) -> Likeliest:
    """The likeliest blur over light of one kind.

    Args:
        shown: the picture.
        within: what the light is like within pixels.
    """

    def unlikely(sigma_px: float) -> float:
        blur = Blur(variance_px2=sigma_px**2, within=within)
        return sum(
            len(left) / 2 * float(np.log(max(float(np.square(left).mean()), LEAST_DN2)))
            for left, *_ in _left(shown, softened(shown.rate, blur))
        )

    found = optimize.minimize_scalar(
        unlikely, bounds=SIGMAS_PX, method="bounded", options={"xatol": CLOSE_PX}
    )
    blur = Blur(variance_px2=float(found.x) ** 2, within=within)
    return Likeliest(
        blur=blur,
        log_likelihood=-float(found.fun),
        at_edges=_at_edges(shown, softened(shown.rate, blur)),
    )


def _left(shown: Picture, soft: Rate) -> Iterator[tuple[Floats, Floats, Floats]]:
    """What the light leaves of each lattice under a smooth shading, how bright that makes it, and
    how steep it is there, (samples,) each.
    """
    for lattice, dn in zip(shown.lattices, shown.dn, strict=True):
        plane = soft[..., "RGB".index(lattice.channel) if lattice.channel in "RGB" else 1]
        light, steep = (lattice.of(one[None])[0].ravel() for one in (plane, _steepness(plane)))
        y, x = (
            one.ravel() for one in np.mgrid[-1 : 1 : dn.shape[0] * 1j, -1 : 1 : dn.shape[1] * 1j]
        )
        clear = dn.ravel() < shown.top_dn
        shades = (np.ones_like(x), x, y, x * x, x * y, y * y)
        columns = np.stack([*(shade * light for shade in shades), np.ones_like(x)], axis=1)[clear]
        amounts, *_ = np.linalg.lstsq(columns, dn.ravel()[clear], rcond=None)
        expected = columns @ amounts
        yield dn.ravel()[clear] - expected, expected - amounts[-1], steep[clear]


def _steepness(plane: Rate) -> Rate:
    down, across = np.gradient(plane)
    return np.asarray(np.hypot(down, across))


def _at_edges(shown: Picture, soft: Rate) -> float:
    """Mean square of what is left at edges over that where the picture is even, each in standard
    deviations of noise whose variance is a square of the brightness there.
    """
    at_edges, elsewhere = [], []
    for left, bright, steep in _left(shown, soft):
        # of a picture that is dark for the most part more samples are as even as can be
        even, no_edge = (steep <= np.quantile(steep, part) for part in (MOST_EVEN, FEWEST_EVEN))
        powers = np.stack([np.ones_like(bright), np.maximum(bright, 0), np.square(bright)], axis=1)
        powers /= np.maximum(powers.max(axis=0), LEAST_DN2)
        parts, _ = optimize.nnls(powers[even], np.square(left[even]))
        variance = np.maximum(powers @ parts, LEAST_DN2)
        z2 = np.minimum(np.square(left) / variance, MOST_SIGMAS**2)
        at_edges.append(z2[~no_edge])
        elsewhere.append(z2[no_edge])
    of_edges, of_others = np.concatenate(at_edges), np.concatenate(elsewhere)
    return float(of_edges.mean() / max(of_others.mean(), LEAST_DN2)) if of_edges.size else 1.0
