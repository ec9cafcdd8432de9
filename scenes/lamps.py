"""What a lamp sends out: its radiant intensity by wavelength, behind its gel, and by direction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.photometry import read_ies
from scenes.spectra import BAND_NM, VISIBLE_NM, Spectrum, lamp_spectrum, spectrum

if TYPE_CHECKING:
    from scenes.lamp import Filter, Lamp

SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7
"""h c / k, CODATA 2018."""

GREEN_NM = 540.0
GREEN_WIDTH_NM = 40.0
"""Centre and standard deviation of the band of a magenta gel: assumed, not measured."""

PLANCK_STEP_NM = 1.0
"""Samples of a black body, linear between them: right to 1e-5."""
PARALLEL = 0.9
"""Cosine beyond which another direction than the picture's right is taken for horizontal."""


def transmission(gel: Filter, nm: ArrayLike) -> NDArray[np.float64]:
    """The part of the light that passes a gel at some wavelengths in nm; see `Filter`."""
    wavelengths = np.asarray(nm, dtype=np.float64)

    def log_shape(at: NDArray[np.float64]) -> NDArray[np.float64]:
        conversion = -SECOND_RADIATION_CONSTANT_NM_K * gel.mired_shift * 1e-6 / at
        magenta = gel.green_density * np.exp(-0.5 * ((at - GREEN_NM) / GREEN_WIDTH_NM) ** 2)
        return np.asarray(conversion - np.log(10) * magenta)

    visible = np.arange(VISIBLE_NM[0], VISIBLE_NM[1] + 1)
    scaled = np.exp(log_shape(wavelengths) - log_shape(visible).max())
    return np.asarray(np.minimum(gel.peak_transmission * scaled, 1.0))


def planck(temperature_k: float, nm: ArrayLike) -> NDArray[np.float64]:
    """The spectrum of a black body by Planck's law, in any unit: 1 / (x^5 (exp(c2 / x T) - 1))."""
    wavelengths = np.asarray(nm, dtype=np.float64)
    exponent = SECOND_RADIATION_CONSTANT_NM_K / (wavelengths * temperature_k)
    return np.asarray((wavelengths / 560.0) ** -5 / np.expm1(exponent))


def bare_spectrum(lamp: Lamp) -> Spectrum:
    """The relative spectral power of a lamp before its gel; 1 over 400 to 700 nm, in 1/nm."""
    if lamp.temperature_k is None:
        assert lamp.spd is not None
        return lamp_spectrum(lamp.spd)
    nm = np.arange(BAND_NM[0], BAND_NM[1] + PLANCK_STEP_NM, PLANCK_STEP_NM)
    glow = spectrum(nm, planck(lamp.temperature_k, nm))
    return glow.times(1 / glow.integral(*VISIBLE_NM))


def emission(lamp: Lamp) -> Spectrum:
    """The spectral radiant intensity at level 1 in W/(sr nm), linear between its samples."""
    bare = bare_spectrum(lamp).times(lamp.intensity_w_per_sr)
    return bare if lamp.filter is None else bare.times(transmission(lamp.filter, bare.nm))


def axes(lamp: Lamp) -> NDArray[np.float64]:
    """Three unit vectors of a lamp, rows: towards horizontal angle 0, 90 degrees, and its axis.

    The axis of a disk or an IES lamp points at `aim_m`; horizontal angle 0 lies as near to the
    right of the picture as it can.
    """
    axis = np.subtract(lamp.aim_m, lamp.position_m)
    axis = axis / np.linalg.norm(axis)
    near = np.array([1.0, 0.0, 0.0] if abs(axis[0]) < PARALLEL else [0.0, 1.0, 0.0])
    across = near - (near @ axis) * axis
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(axis, across), axis])


def relative_intensity(lamp: Lamp, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Intensity over `intensity_w_per_sr` in some directions away from the lamp.

    Args:
        lamp: the lamp; of a disk or a tube, any small part of it.
        directions: unit vectors (..., 3).
    """
    if lamp.kind == "disk":
        return np.asarray(np.maximum(directions @ axes(lamp)[2], 0.0))
    if lamp.kind == "tube":
        along = directions @ (np.array(lamp.axis) / np.linalg.norm(lamp.axis))
        return np.asarray(np.sqrt(np.maximum(1 - along**2, 0.0)))
    if lamp.ies is None:
        return np.ones(directions.shape[:-1])
    x, y, z = np.moveaxis(directions @ axes(lamp).T, -1, 0)
    vertical = np.degrees(np.arccos(np.clip(z, -1, 1)))
    return read_ies(lamp.ies).at(vertical, np.degrees(np.arctan2(y, x)))
