"""What a lamp sends out: its radiant intensity, wavelength by wavelength, behind its gel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.spectra import VISIBLE_NM, Spectrum, lamp_spectrum

if TYPE_CHECKING:
    from scenes.scene import Filter, Lamp

SECOND_RADIATION_CONSTANT_NM_K = 1.438776877e7
"""h c / k, CODATA 2018."""

GREEN_NM = 540.0
GREEN_WIDTH_NM = 40.0
"""Centre and standard deviation of the band of a magenta gel: assumed, not measured."""


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


def emission(lamp: Lamp) -> Spectrum:
    """The spectral radiant intensity at level 1 in W/(sr nm), linear between its samples."""
    bare = lamp_spectrum(lamp.spd).times(lamp.intensity_w_per_sr)
    return bare if lamp.filter is None else bare.times(transmission(lamp.filter, bare.nm))
