"""Why a picture of an even card is not even: each cause along the two axes of the image.

    shading = (R0 / R)^2  x  cos(theta) / cos(theta0)  x  cos^4(alpha) / cos^4(alpha0)  x  open part

relative to the middle of the image: distance of the lamp, slant of its light, natural fall-off of
the lens, and what a barrel or rims leave open. A lamp of some size, or with a distribution of its
own, adds a factor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from render.closed_form import (
    detector_factor,
    irradiance_factor,
    material_map,
    natural_falloff,
    sight,
    surface,
)
from render.rate import RateImage
from render.spectral import channel_weights, material_rates, white_rates
from scenes.field import WAVELENGTHS_NM
from scenes.geometry import turn
from scenes.patches import patches
from scenes.scene import Scene
from scenes.spectra import response

Array = NDArray[np.float64]
GREEN = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Shading along one axis of the image.

    Attributes:
        axis: ``x`` or ``y``.
        position_px: from the left or from the top.
        distance, slant, natural, opening, lamp: the factors, 1 in the middle of the image.
        total: their product, the closed form.
        measured: the rate image over its reflectances; NaN outside panels.
    """

    axis: str
    position_px: Array
    distance: Array
    slant: Array
    natural: Array
    opening: Array
    lamp: Array
    total: Array
    measured: Array


def profiles(scene: Scene, image: RateImage) -> tuple[Profile, Profile]:
    """The shading of a rate image of a scene, along x and along y, in green.

    Along the row and the column that cross most of the panels; of equals, those nearest to the
    middle.
    """
    lamp = scene.named(image.header.lamp)
    seen, facing = sight(scene), turn(scene)[:, 2]
    curves = response(scene.detector.response, scene.detector.infrared_cut)
    weights = channel_weights(lamp, curves, WAVELENGTHS_NM)
    power, moved = detector_factor(scene, seen, weights)
    power, moved = (p if p.ndim == 2 else p[..., GREEN] for p in (power, moved))
    x, y, z = seen.x_m * moved, seen.y_m * moved, seen.z_m
    away = [a - b for a, b in zip((x, y, z), lamp.position_m, strict=True)]
    far = np.sqrt(away[0] ** 2 + away[1] ** 2 + away[2] ** 2)
    slant = -(away[0] * facing[0] + away[1] * facing[1] + away[2] * facing[2]) / far
    lit = irradiance_factor(lamp, x, y, z, facing)
    natural = natural_falloff(seen.slope)
    factors = [far**-2, slant, natural, power / natural, lit * far**2 / slant, lit * power]
    even = _over_reflectance(scene, image)
    clear = np.zeros(even.shape, dtype=bool)
    for panel in image.header.panels:
        clear[panel.window] = True
    even = np.where(clear, even, np.nan)
    row, column = (_busiest(clear.sum(axis=axis)) for axis in (1, 0))
    middle = even.shape[0] // 2, even.shape[1] // 2
    scaled = [
        np.broadcast_to(f, even.shape) / np.broadcast_to(f, even.shape)[middle] for f in factors
    ]
    # The middle itself may be no panel: the measured profile is laid over the closed form.
    scaled.append(even * np.nansum(scaled[-1][clear]) / np.nansum(even[clear]))
    return (
        _profile("x", [f[row] for f in scaled]),
        _profile("y", [f[:, column] for f in scaled]),
    )


def _profile(axis: str, rows: list[Array]) -> Profile:
    distance, slant, natural, opening, lamp, total, measured = rows
    return Profile(
        axis=axis,
        position_px=np.arange(0.5, total.size),
        distance=distance,
        slant=slant,
        natural=natural,
        opening=opening,
        lamp=lamp,
        total=total,
        measured=measured,
    )


def _busiest(count: NDArray[np.intp]) -> int:
    """The line with most clear pixels; of equals the one nearest to the middle."""
    best = np.flatnonzero(count == count.max())
    return int(best[np.abs(best - count.size / 2).argmin()])


def _over_reflectance(scene: Scene, image: RateImage) -> Array:
    """The green rate over what each panel reflects of green light."""
    lamp = scene.named(image.header.lamp)
    seen = sight(scene)
    rates = material_rates(scene, lamp)[:, GREEN]
    where = material_map(scene, seen)
    matt, shine = surface(scene, lamp, seen)
    even = image.rate_e_per_s[..., GREEN].astype(np.float64)
    if scene.chart.gloss is not None:
        lit = irradiance_factor(lamp, seen.x_m, seen.y_m, seen.z_m, turn(scene)[:, 2])
        white = float(white_rates(scene, lamp)[GREEN])
        reflected = rates[where] * lit / np.pi * matt + white * np.asarray(shine)
        return np.asarray(even * lit / np.where(where < len(patches(scene.chart)), reflected, 1.0))
    return np.asarray(even / rates[where])
