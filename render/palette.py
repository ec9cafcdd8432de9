"""What the path tracer is told of colour: a film, and a reflectance for every material.

The lamp's spectrum is on the film's side: film = lamp x quantum efficiency x lambda / (h c), and
the lamp itself shines evenly. With one lamp per rendering it is the same integral, and wavelengths
are then drawn where the lamp shines, so that a mercury line takes the share of paths it deserves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import constants

from scenes.lamp import Lamp
from scenes.lamps import emission
from scenes.patches import flat, patches
from scenes.scene import Scene
from scenes.spectra import BAND_NM, CHANNELS, VISIBLE_NM, Spectrum, spectrum

Array = NDArray[np.float64]

STEP_NM, FINE_STEP_NM = 1.0, 0.1
"""Grid of a film, and of the integrals: a product of tables at 5 nm is linear between the samples
of the first to 1e-5, of the second to 1e-7."""
SPARE = "spare"
BANDS_NM = {"B": (400.0, 475.0), "G": (475.0, 550.0), "R": (550.0, 625.0), SPARE: (625.0, 700.0)}
GUARD_NM = 10.0
"""Where the bands of integrated colour lie, in rising order, and how far their films keep from
the borders, where one reflectance passes into the next.

Mitsuba lets a path carry four wavelengths, a quarter of the film apart. With four bands of the same
weight each path has one in every band, so that all channels share all luck; nobody looks at the
fourth band.
"""
QUANTILES = 513
"""Steps of the true wavelengths behind an even film."""
CARD, WALL = "card", "wall"


@dataclass(frozen=True, kw_only=True, eq=False)
class Palette:
    """What Mitsuba is told.

    Attributes:
        film_nm: an even grid of wavelengths.
        film: response of each channel on that grid, any unit; after R, G and B perhaps one that
            nobody looks at.
        materials: reflectance by panel name, and of the card and the wall.
        white: for each channel, what a white plate under 1 sr of this lamp gives, in e-/(s sr):
            the true integral that stands behind the film's.
    """

    film_nm: Array
    film: dict[str, Array]
    materials: dict[str, Spectrum]
    white: Array


def _grid(curves: Mapping[str, Spectrum], step_nm: float) -> Array:
    """An even grid over what the camera sees: curves end abruptly where their tables do."""
    low = max(BAND_NM[0], min(curve.nm[0] for curve in curves.values()))
    high = min(BAND_NM[1], max(curve.nm[-1] for curve in curves.values()))
    return np.linspace(low, high, math.ceil((high - low) / step_nm) + 1)


def _response(
    lamp: Lamp, peak: float, curves: Mapping[str, Spectrum], nm: Array
) -> dict[str, Array]:
    """Lamp x quantum efficiency x lambda / (h c) in e-/(s sr nm)."""
    light = emission(lamp).at(nm) * peak * nm * 1e-9 / (constants.h * constants.c)
    return {channel: light * curves[channel].at(nm) for channel in CHANNELS}


def _materials(scene: Scene) -> dict[str, Spectrum]:
    """The reflectances of the panels, the card and the wall."""
    result = {patch.name: patch.reflectance for patch in patches(scene.chart)}
    result[CARD] = flat(scene.chart.frame_reflectance)
    result[WALL] = flat(scene.surround_reflectance)
    return result


def sampled(scene: Scene, lamp: Lamp, curves: Mapping[str, Spectrum]) -> Palette:
    """True colour, wavelength by wavelength."""
    nm = _grid(curves, STEP_NM)
    film = _response(lamp, scene.detector.peak_quantum_efficiency, curves, nm)
    white = np.array([np.trapezoid(film[channel], nm) for channel in CHANNELS])
    film = {channel: film[channel] / white.max() for channel in CHANNELS}
    return Palette(film_nm=nm, film=film, materials=_materials(scene), white=white)


def integrated(scene: Scene, lamp: Lamp, curves: Mapping[str, Spectrum]) -> Palette:
    """A band for each channel, in which a material has the mean reflectance that it sees.

    Exact for light that is reflected once: the channel is then linear in the reflectance.
    """
    nm = _grid(curves, FINE_STEP_NM)
    weight = _response(lamp, scene.detector.peak_quantum_efficiency, curves, nm)
    white = {channel: float(np.trapezoid(weight[channel], nm)) for channel in CHANNELS}
    materials = {}
    for name, curve in _materials(scene).items():
        nodes_nm, means = [], []
        for channel in reversed(CHANNELS):
            low_nm, high_nm = BANDS_NM[channel]
            nodes_nm += [low_nm, high_nm - STEP_NM]
            means += [np.trapezoid(weight[channel] * curve.at(nm), nm) / white[channel]] * 2
        materials[name] = spectrum([*nodes_nm, *BANDS_NM[SPARE]], [*means, *means[-2:]])
    film_nm = np.arange(BANDS_NM["B"][0], BANDS_NM[SPARE][1] + STEP_NM, STEP_NM)
    film = {}
    for channel in (*CHANNELS, SPARE):
        low_nm, high_nm = BANDS_NM[channel]
        inside = (low_nm + GUARD_NM <= film_nm) & (film_nm <= high_nm - GUARD_NM)
        film[channel] = inside.astype(np.float64)
    return Palette(
        film_nm=film_nm,
        film=film,
        materials=materials,
        white=np.array([white[channel] for channel in CHANNELS]),
    )


def single(
    scene: Scene, lamp: Lamp, curves: Mapping[str, Spectrum], channel: str
) -> tuple[Palette, Array]:
    """One channel alone: grey materials, and the true wavelengths behind an even film.

    A real lens bends every wavelength otherwise, so a path has a wavelength of its own. The film
    runs evenly from 400 to 700; at the part q of it stands the wavelength below which the channel
    gets the part q of its light, so that wavelengths are drawn as the channel sees them. (Q,) from
    the film's beginning to its end.
    """
    nm = _grid(curves, FINE_STEP_NM)
    weight = _response(lamp, scene.detector.peak_quantum_efficiency, curves, nm)[channel]
    white = float(np.trapezoid(weight, nm))
    below = np.concatenate([[0.0], np.cumsum((weight[1:] + weight[:-1]) / 2)]) / (
        weight.sum() - (weight[0] + weight[-1]) / 2
    )
    true_nm = np.interp(np.linspace(0, 1, QUANTILES), below, nm)
    materials = {
        name: flat(float(np.trapezoid(weight * curve.at(nm), nm)) / white)
        for name, curve in _materials(scene).items()
    }
    film_nm = np.array(VISIBLE_NM)
    palette = Palette(
        film_nm=film_nm,
        film={channel: np.ones(2)},
        materials=materials,
        white=np.array([white]),
    )
    return palette, true_nm
