"""Integrals over the wavelength: what a panel under a lamp gives in each channel.

Spectra are linear between samples, so a product of three of them and the wavelength is a
polynomial of degree 4 in each cell, which three Gauss-Legendre points integrate exactly.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from scenes.lamp import Lamp
from scenes.lamps import emission
from scenes.patches import patches
from scenes.scene import Scene
from scenes.spectra import BAND_NM, CHANNELS, Spectrum, response

Array = NDArray[np.float64]

PLANCK_J_S = 6.62607015e-34
LIGHT_SPEED_M_PER_S = 299792458.0
GAUSS_POINT, GAUSS_WEIGHT = np.polynomial.legendre.leggauss(3)


def electrons_per_joule(quantum_efficiency: Array, nm: Array) -> Array:
    """Electrons for a joule of light: QE lambda / (h c)."""
    return quantum_efficiency * nm * 1e-9 / (PLANCK_J_S * LIGHT_SPEED_M_PER_S)


def spectral_integral(
    light: Spectrum, reflectance: Spectrum | float, quantum_response: Spectrum, peak: float
) -> float:
    """Integral of intensity x reflectance x electrons per joule: e-/(s sr)."""
    curves = [light, quantum_response]
    curves += [reflectance] if isinstance(reflectance, Spectrum) else []
    nodes = functools.reduce(np.union1d, [curve.nm for curve in curves])
    low, high = max(c.nm[0] for c in curves[:2]), min(c.nm[-1] for c in curves[:2])
    nodes = nodes[(nodes >= low) & (nodes <= high)]
    half, middle = np.diff(nodes)[:, None] / 2, (nodes[1:] + nodes[:-1])[:, None] / 2
    nm = middle + half * GAUSS_POINT
    reflected = reflectance.at(nm) if isinstance(reflectance, Spectrum) else reflectance
    integrand = light.at(nm) * reflected * electrons_per_joule(peak * quantum_response.at(nm), nm)
    return float((half * GAUSS_WEIGHT * integrand).sum())


def channel_weights(lamp: Lamp, curves: Mapping[str, Spectrum], nodes_nm: Array) -> Array:
    """How each channel weighs what is linear between some wavelengths, (3, N), summing to 1."""
    light = emission(lamp)
    nm = np.arange(BAND_NM[0], BAND_NM[1] + 0.5, 0.5)
    hats = np.stack([np.interp(nm, nodes_nm, row) for row in np.eye(nodes_nm.size)], axis=1)
    seen = np.stack([light.at(nm) * curves[channel].at(nm) * nm for channel in CHANNELS])
    return np.asarray(seen @ hats / seen.sum(axis=1, keepdims=True))


def material_rates(
    scene: Scene, lamp: Lamp, response_curves: Mapping[str, Spectrum] | None = None
) -> Array:
    """Spectral integrals of the panels, then the card and the wall, (N + 2, 3) in e-/(s sr)."""
    light = emission(lamp)
    curves = response_curves or response(scene.detector.response, scene.detector.infrared_cut)
    materials: list[Spectrum | float] = [patch.reflectance for patch in patches(scene.chart)]
    materials += [scene.chart.frame_reflectance, scene.surround_reflectance]
    peak = scene.detector.peak_quantum_efficiency
    return np.array(
        [[spectral_integral(light, m, curves[c], peak) for c in CHANNELS] for m in materials]
    )


def white_rates(
    scene: Scene, lamp: Lamp, response_curves: Mapping[str, Spectrum] | None = None
) -> Array:
    """The spectral integral of a white surface, (3,) in e-/(s sr)."""
    curves = response_curves or response(scene.detector.response, scene.detector.infrared_cut)
    light, peak = emission(lamp), scene.detector.peak_quantum_efficiency
    return np.array([spectral_integral(light, 1.0, curves[c], peak) for c in CHANNELS])
