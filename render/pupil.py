"""The barrel: what it leaves open of the aperture, and the ring that stands for it.

The aperture seen from a pixel is its disc less what the barrel's round opening, projected through
the pixel's point of sharp focus, does not cover. The open area is summed slice by slice along the
shift, so that it shares nothing with the closed form of two overlapping circles in `closed_form`,
and so that a test can hold one against the other.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from scenes.scene import Scene

SLICES = 1000
RADII = 1000
"""Slices of the aperture, and radii in the image between which it is interpolated: good to 1e-5."""
RING_SIDES = 512
"""Sides of the polygon that stands for the barrel's opening."""


def open_fraction(scene: Scene) -> NDArray[np.float64]:
    """The open part of the aperture for each pixel's chief ray, (H, W), from 0 to 1."""
    lens, detector = scene.lens, scene.detector
    if lens.barrel is None:
        return np.ones((detector.height_px, detector.width_px))
    pitch_m = detector.pitch_um * 1e-6
    x_m = (np.arange(detector.width_px) + 0.5 - detector.width_px / 2) * pitch_m
    y_m = (np.arange(detector.height_px) + 0.5 - detector.height_px / 2) * pitch_m
    radius_m = np.hypot(x_m[None, :], y_m[:, None])
    sampled_m = np.linspace(0, float(radius_m.max()), RADII)
    part = np.array([_open_at(scene, float(radius)) for radius in sampled_m])
    return np.asarray(np.interp(radius_m, sampled_m, part))


def _open_at(scene: Scene, image_radius_m: float) -> float:
    """The open part for a point at some distance from the centre of the detector."""
    lens, barrel = scene.lens, scene.lens.barrel
    assert barrel is not None
    aperture_m = lens.aperture_radius_m
    depth_m = barrel.distance_mm * 1e-3
    focus_m = image_radius_m / lens.image_distance_m * lens.focus_distance_m
    shrink = 1 - depth_m / lens.focus_distance_m
    opening_m = barrel.radius_mm * 1e-3 / shrink
    centre_m = -focus_m * (depth_m / lens.focus_distance_m) / shrink
    angle = (np.arange(SLICES) + 0.5) * np.pi / SLICES - np.pi / 2
    height_m, thickness_m = aperture_m * np.sin(angle), aperture_m * np.cos(angle) * np.pi / SLICES
    of_aperture = aperture_m * np.cos(angle)
    of_opening = np.sqrt(np.maximum(opening_m**2 - height_m**2, 0))
    length_m = np.minimum(of_aperture, centre_m + of_opening) - np.maximum(
        -of_aperture, centre_m - of_opening
    )
    open_m2 = np.sum(np.maximum(length_m, 0) * thickness_m)
    return float(open_m2 / (np.pi * aperture_m**2))


def ring_mesh(scene: Scene) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """The barrel as a flat ring: vertices (2 N, 3) in m and triangles (2 N, 3).

    Its opening is a polygon with the area of the circle; it is wide enough to stop every ray of
    the image that misses the opening.
    """
    lens, detector, barrel = scene.lens, scene.detector, scene.lens.barrel
    assert barrel is not None
    radius_m, depth_m = barrel.radius_mm * 1e-3, barrel.distance_mm * 1e-3
    diagonal_m = math.hypot(detector.width_px, detector.height_px) * detector.pitch_um * 1e-6
    reach_m = lens.aperture_radius_m + depth_m * diagonal_m / 2 / lens.image_distance_m
    step = 2 * math.pi / RING_SIDES
    radii_m = radius_m * math.sqrt(step / math.sin(step)), 1.5 * max(reach_m, radius_m)
    angle = np.arange(RING_SIDES) * step
    z_m = np.full_like(angle, scene.camera_distance_m - depth_m)
    rings = [np.stack([r * np.cos(angle), r * np.sin(angle), z_m], axis=1) for r in radii_m]
    here = np.arange(RING_SIDES)
    after = (here + 1) % RING_SIDES
    halves = (here, after, after + RING_SIDES), (here, after + RING_SIDES, here + RING_SIDES)
    return np.concatenate(rings), np.concatenate([np.stack(half, axis=1) for half in halves])
