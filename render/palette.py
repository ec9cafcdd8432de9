"""What the path tracer is told of colour: a film, and a reflectance for every material.

The lamp's spectrum is on the film's side: film = lamp x quantum efficiency x lambda / (h c), and
the lamp itself shines evenly. With one lamp per rendering it is the same integral, and wavelengths
are then drawn where the lamp shines, so that a mercury line takes the share of paths it deserves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import constants

from scenes.geometry import PANEL_NAMES
from scenes.lamps import emission
from scenes.scene import Lamp, Scene
from scenes.spectra import BAND_NM, CHANNELS, Spectrum, reflectances, spectrum

Array = NDArray[np.float64]

FILM_NM = np.arange(BAND_NM[0], BAND_NM[1] + 1)
"""A sample every nm: products of tables at 5 nm are linear between these to 1e-5."""
FINE_NM = np.linspace(*BAND_NM, 4001)
"""A sample every 0.1 nm, for integrals."""
BANDS_NM = {"R": (600.0, 700.0), "G": (500.0, 600.0), "B": (400.0, 500.0)}
GUARD_NM = 10.0
"""Where the bands of integrated colour lie, and how far their films keep from the borders."""
CARD, WALL = "card", "wall"


@dataclass(frozen=True, kw_only=True, eq=False)
class Palette:
    """What Mitsuba is told.

    Attributes:
        film: response of each channel on `FILM_NM`, any unit.
        materials: reflectance by panel name, and of the card and the wall.
        white: for each channel, what a white plate under 1 sr of this lamp gives, in e-/(s sr):
            the true integral that stands behind the film's.
    """

    film: dict[str, Array]
    materials: dict[str, Spectrum]
    white: Array


def _response(
    lamp: Lamp, peak: float, curves: Mapping[str, Spectrum], nm: Array
) -> dict[str, Array]:
    """Lamp x quantum efficiency x lambda / (h c) in e-/(s sr nm)."""
    light = emission(lamp).at(nm) * peak * nm * 1e-9 / (constants.h * constants.c)
    return {channel: light * curves[channel].at(nm) for channel in CHANNELS}


def _materials(scene: Scene) -> dict[str, Spectrum]:
    """The reflectances of the panels, the card and the wall."""
    result = dict(zip(PANEL_NAMES, reflectances(scene.chart.reflectances), strict=True))
    result[CARD] = spectrum(BAND_NM, [scene.chart.frame_reflectance] * 2)
    result[WALL] = spectrum(BAND_NM, [scene.surround_reflectance] * 2)
    return result


def sampled(scene: Scene, lamp: Lamp, curves: Mapping[str, Spectrum]) -> Palette:
    """True colour, wavelength by wavelength."""
    peak = scene.detector.peak_quantum_efficiency
    film = _response(lamp, peak, curves, FILM_NM)
    white = np.array([np.trapezoid(film[channel], FILM_NM) for channel in CHANNELS])
    film = {channel: film[channel] / white.max() for channel in CHANNELS}
    return Palette(film=film, materials=_materials(scene), white=white)


def integrated(scene: Scene, lamp: Lamp, curves: Mapping[str, Spectrum]) -> Palette:
    """Three bands, in each of which a material has its mean reflectance as that channel sees it.

    Exact for light that is reflected once: the channel is then linear in the reflectance.
    """
    peak = scene.detector.peak_quantum_efficiency
    weight = _response(lamp, peak, curves, FINE_NM)
    white = {channel: np.trapezoid(weight[channel], FINE_NM) for channel in CHANNELS}
    materials = {}
    for name, curve in _materials(scene).items():
        reflectance = curve.at(FINE_NM)
        nodes = []
        for channel, (low_nm, high_nm) in sorted(BANDS_NM.items(), key=lambda item: item[1]):
            mean = np.trapezoid(weight[channel] * reflectance, FINE_NM) / white[channel]
            nodes += [(low_nm, mean), (high_nm - 1, mean)]
        materials[name] = spectrum(*zip(*nodes, strict=True))
    film = {
        channel: ((low + GUARD_NM <= FILM_NM) & (high - GUARD_NM >= FILM_NM)).astype(np.float64)
        for channel, (low, high) in BANDS_NM.items()
    }
    return Palette(film=film, materials=materials, white=np.array([white[c] for c in CHANNELS]))
