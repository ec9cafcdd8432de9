"""GalSim's silicon: pixels whose borders move with the charge in them, and tree rings."""

from __future__ import annotations

import functools

import galsim
import numpy as np
from scipy import ndimage

from camtruth.blind.foreign.outsider import About, Numbers, Outsider

SOURCE = "galsim"
REACH = 4
PROBE_E = 1000.0
HALF = 0.5
"""Charge arrives while the borders move: on average they have moved half of the way."""


def brighter_fatter(electrons: Numbers, strength: float, about: About) -> Numbers:
    """Charge goes with a pixel's area as its own and its neighbours' charge changes it."""
    kernel = strength * HALF * area_per_e()
    moved = [frame * ndimage.convolve(frame, kernel, mode="nearest") for frame in electrons]
    return np.asarray(electrons + np.stack(moved), dtype=electrons.dtype)


@functools.cache
def area_per_e() -> Numbers:
    """By how much an electron in the middle pixel changes the areas around it: (2 REACH + 1)^2.

    GalSim takes seconds a frame to move every corner, so it is asked once, with charge in a single
    pixel; areas are linear in charge to first order.
    """
    side = 2 * REACH + 1
    sensor = galsim.SiliconSensor(rng=galsim.BaseDeviate(1))
    charge = np.zeros((side, side), dtype=np.float32)
    still = sensor.calculate_pixel_areas(galsim.ImageF(charge.copy())).array.copy()
    charge[REACH, REACH] = PROBE_E
    moved = sensor.calculate_pixel_areas(galsim.ImageF(charge)).array
    return np.asarray((moved - still) / PROBE_E, dtype=np.float64)


def tree_rings(electrons: Numbers, strength: float, about: About) -> Numbers:
    """Rings of the silicon's doping about a point outside the chip move the pixels' borders."""
    area = ringed(*electrons.shape[1:])
    return np.asarray(electrons * (1 + strength * (area - 1)), dtype=electrons.dtype)


@functools.cache
def ringed(height: int, width: int) -> Numbers:
    """Areas of the pixels under rings 30 pixels apart that move borders by up to 1 % of one."""
    centre = galsim.PositionD(-0.3 * width, -0.2 * height)
    rings = galsim.SiliconSensor.simple_treerings(0.01, 30.0, 4.0 * (height + width))
    sensor = galsim.SiliconSensor(
        rng=galsim.BaseDeviate(1), treering_func=rings, treering_center=centre
    )
    image = galsim.ImageF(np.zeros((height, width), dtype=np.float32))
    area = sensor.calculate_pixel_areas(image, use_flux=False).array.astype(np.float64)
    return np.asarray(area / area.mean())


OUTSIDERS = (
    Outsider(
        name="galsim brighter-fatter",
        source=SOURCE,
        answers=("brighter_fatter",),
        stage="photosite",
        place="electrons",
        weakest=0.1,
        strongest=100.0,
        act=brighter_fatter,
        order=52,
    ),
    Outsider(
        name="galsim tree rings",
        source=SOURCE,
        answers=("large_scale_prnu",),
        stage="photosite",
        place="electrons",
        weakest=0.01,
        strongest=30.0,
        act=tree_rings,
        order=51,
    ),
)
