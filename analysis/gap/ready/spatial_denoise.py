"""Where a camera begins that smooths its noise in space: by how samples that were measured agree.

A mosaic's samples of one colour are two pixels apart and have independent noise. A window of three
by three over the filled-in picture mixes them all the same, because what lies between was made of
them. With the weights c, a and b of a pixel, its straight and its diagonal neighbours, red and blue
become sums over their own lattice by the kernel

    p q p
    q C q        C = c + 2a + b,    q = (a + b) / 2,    p = b / 4
    p q p

so that noise of variance 1 becomes V = C^2 + 4q^2 + 4p^2 and has the covariance 2qC + 4pq with the
next sample and 2pC + 2q^2 with the diagonal one. Frames of a camera without a mosaic, and raw ones
colour by colour, have C = c, q = a, p = b.
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from analysis.gap.calibrate.refine import refined
from analysis.gap.camera.base import Base, channels_alike
from analysis.gap.look.agreeing import LEAST_CORRELATION, beyond_the_next, correlations
from analysis.gap.look.lattices import of_a_mosaic
from analysis.gap.ready.hints import DirectReading
from analysis.gap.ready.moments import by_moments
from analysis.gap.ready.setting import Setting, halves
from sensor.effects.spatial_denoise import SpatialDenoise

Floats = NDArray[np.float64]

ALIKE = 2.0
"""Factor by which correlations of both directions and of all levels differ at most."""

LINEAR_DN = 64.0
"""Threshold of a filter that mixes whatever it meets."""

WIDE, WIDE_PLAIN = 0.1, 0.4
"""Correlation with the sample after the next one from which a window is wider than three by three,
of which equal weights leave (q^2 + 2 p^2) / V = 1/18, and 1/3 where no colours are filled in."""

OF_NOISE = (1.5, 3.0)
"""Thresholds of a filter that mixes the less the more pixels differ, in standard deviations of the
noise of the brightest shot."""

OF_THE_GAIN = (1.0, 0.6)
"""Parts of the gain by moments with it: what keeps noise that is large, keeps more of it where it
is looked at than a window of the same weights would."""

SOFT = (1.0, 2.0, 3.0)
"""How such a filter tells them apart: each colour by itself, all together, or by patches."""


def filtered(setting: Setting) -> DirectReading | None:
    """A filter in space with its weights, and the base by moments of frames without it.

    It takes noise away that a base without it has to take for a smaller gain, so that the base
    which fits is no place to begin. None where noise is not smoothed, in lit frames of every level
    and along rows and columns alike.

    Args:
        setting: the capture.
    """
    lattices = setting.scenery.view.lattices
    lit = [stack for stack in setting.key_frames if not stack.shot.dark]
    coloured = setting.scenery.body.pixels == "rgb8"
    if not lit or (coloured and not of_a_mosaic(lattices)):
        return None  # where nobody knows what was measured, filled-in colours agree anyway
    found = np.array([correlations(stack, lattices) for stack in lit])
    straight = found[:, :2]
    by_direction, by_level = straight.mean(axis=0), straight.mean(axis=1)
    if by_direction.min() < LEAST_CORRELATION or not (_alike(by_direction) and _alike(by_level)):
        return None
    a, b = weights_of(float(straight.mean()), float(found[:, 2].mean()), coloured)
    if a <= 0:
        return None
    _, base = by_moments(setting)
    left = [power_left(a, b, channel if coloured else "") for channel in base.channels]
    base = base.noisier(1.0 / np.array(left))
    widest = max(beyond_the_next(stack, lattices) for stack in setting.key_frames)
    if widest > (WIDE if coloured else WIDE_PLAIN):
        return _wide(setting, base)
    return DirectReading(
        hints={
            "strength": a * (5.0 + 4.0 * b / a),
            "diagonal": b / a,
            "threshold_dn": LINEAR_DN,
        },
        exact=False,
        base=base,
    )


def _wide(setting: Setting, base: Base) -> DirectReading:
    """A window of five by five that keeps what differs by more than noise does: of a few the one
    with which twins look most like the frames.

    Args:
        setting: the capture.
        base: by moments of frames without a filter.
    """
    fit_half, _ = halves(setting.seen)
    brightest_dn = max(float(stack.dn[0].mean()) for stack in setting.key_frames)
    noise_dn2 = base.gain_dn_per_e * np.maximum(brightest_dn - base.black_dn, 0.0) + base.read_dn2
    noise_dn = float(np.sqrt(noise_dn2.mean()))
    alike = channels_alike(base) if "G" in base.channels else base
    tried = (
        (
            alike.noisier(np.full(len(base.channels), part)),
            SpatialDenoise(
                strength=1.0, threshold_dn=times * noise_dn, diagonal=1.0, window=3.0, soft=soft
            ),
        )
        for part, soft, times in itertools.product(OF_THE_GAIN, SOFT, OF_NOISE)
    )
    against = [refined(begun, fit_half, setting.scenery, (one,)) for begun, one in tried]
    likeliest = min(against, key=lambda one: one.deviance)
    hints = dataclasses.asdict(likeliest.effects[-1])
    return DirectReading(hints=hints, exact=False, base=likeliest.base)


def _alike(values: Floats) -> bool:
    return bool(values.max() <= ALIKE * values.min())


def _kernel(a: float, b: float, coloured: bool) -> tuple[float, float, float]:
    """Weights of a sample, of the next and of the diagonal one of its own lattice."""
    c = 1.0 - 4.0 * a - 4.0 * b
    return (c + 2 * a + b, (a + b) / 2, b / 4) if coloured else (c, a, b)


def weights_of(straight: float, diagonal: float, coloured: bool) -> tuple[float, float]:
    """Weights of straight and diagonal neighbours that make these correlations."""

    def off(weights: Floats) -> list[float]:
        middle, q, p = _kernel(weights[0], weights[0] * weights[1], coloured)
        power = middle**2 + 4 * q**2 + 4 * p**2
        return [
            (2 * q * middle + 4 * p * q) / power - straight,
            (2 * p * middle + 2 * q**2) / power - diagonal,
        ]

    found = least_squares(off, (0.05, 0.5), bounds=((0.0, 0.0), (0.2, 1.0))).x
    return float(found[0]), float(found[0] * found[1])


def power_left(a: float, b: float, channel: str) -> float:
    """Variance that is left of a measured sample's noise; no channel stands for no mosaic."""
    if channel != "G":
        middle, q, p = _kernel(a, b, coloured=channel != "")
        return middle**2 + 4 * q**2 + 4 * p**2
    # its diagonal neighbours were measured, and its straight ones are means of four
    c = 1.0 - 4.0 * a - 4.0 * b
    return (c + a) ** 2 + 4 * (a / 2 + b) ** 2 + 4 * (a / 4) ** 2
