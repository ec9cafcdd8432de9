"""What a real lens does across its field, tabulated from traced rays against the image radius.

For points of the detector at rising distances from its centre: the chief ray, which passes the
middle of the stop; the outline of the open pupil, as the rims leave it; the etendue

    G = Integral over the open pupil of cos^4(theta) / l^2 dA

with theta and l between detector and exit pupil, which for a thin lens is A cos^4 / v^2; and where
on the chart the light comes from. The outline is found direction by direction by bisection, so
that the integral over what is inside it is smooth and needs few rays.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes.errors import SceneError
from scenes.lens import Lens
from scenes.prescription import Mounted, mounted
from scenes.ray_trace import Rays, trace

Array = NDArray[np.float64]

RADII, AROUND, RINGS = 33, 64, 6
"""Image radii; directions in half the pupil; Gaussian rings in it. Between radii G is good to
1e-4, by comparison with 161."""
WAVELENGTHS_NM = np.linspace(400.0, 700.0, 7)
WIDEST = 4.0
"""The open pupil lies within so many paraxial radii of the chief ray."""
HALVINGS = 40


@dataclass(frozen=True, kw_only=True, eq=False)
class Field:
    """Tables against image radius (R,) and wavelength (W,), lengths in m.

    Attributes:
        radius_m: image radii, from 0.
        crossing_m, slope: of the chief ray in the scene, at 550 nm: how far before the first
            principal plane it crosses the axis, and its slope there.
        etendue: G in m2 per m2, (R, W).
        centre_m, half_x_m, half_y_m: an ellipse in the plane of the exit pupil that holds the
            open pupil at all wavelengths; x is away from the axis.
        outline: rays through the outline of the pupil, as x and y at the first principal plane and
            slopes towards the scene, four of (R, W, A).
        centroid: of all rays, as x at the first principal plane and slope, two of (R, W).
    """

    radius_m: Array
    crossing_m: Array
    slope: Array
    etendue: Array
    centre_m: Array
    half_x_m: Array
    half_y_m: Array
    outline: tuple[Array, Array, Array, Array]
    centroid: tuple[Array, Array]

    def centroid_m(self, distance_m: float, channel: Array) -> Array:
        """Distance from the axis of the middle of the light at a distance, (R,)."""
        place, slope = self.centroid
        return np.asarray((place + slope * distance_m) @ channel)

    def blur_m(self, distance_m: float) -> Array:
        """Greatest distance of any ray from the chief ray at a distance before the lens, (R,)."""
        x, y, sx, sy = (values.reshape(self.radius_m.size, -1) for values in self.outline)
        chief = (distance_m - self.crossing_m) * self.slope
        return np.asarray(
            np.hypot(x + sx * distance_m - chief[:, None], y + sy * distance_m).max(axis=1)
        )


@functools.lru_cache(maxsize=16)
def field(lens: Lens, corner_m: float) -> Field:
    """The tables of a real lens out to a corner of the detector, and a little beyond.

    Raises:
        SceneError: for a lens that leaves the corner dark.
    """
    body = mounted(lens)
    radius = np.linspace(0.0, 1.02 * corner_m, RADII)
    nm = np.array([550.0])
    centre = _chief(body, radius, nm)
    chief = _aimed(body, radius, centre, np.zeros_like(radius), nm)
    if not chief.alive.all():
        seen_mm = radius[chief.alive].max(initial=0.0) * 1e3
        raise SceneError(
            f"lens '{lens.prescription}' lights the detector to {seen_mm:.2f} mm from its centre",
            f"expected at least {corner_m * 1e3:.2f} mm",
            "use a longer focal_length_mm or a smaller detector",
        )
    slope = -chief.dx / chief.dz
    place = chief.x + slope * chief.z
    # On the axis the crossing is the limit: that of the second radius, to second order.
    crossing = np.divide(-place, slope, out=np.zeros_like(slope), where=radius > 0)
    crossing[0] = (4 * crossing[1] - crossing[2]) / 3
    per_colour = [_open(body, radius, centre, float(colour)) for colour in WAVELENGTHS_NM]
    low = np.min([x.min(axis=1) for x, _, _, _, _ in per_colour], axis=0)
    high = np.max([x.max(axis=1) for x, _, _, _, _ in per_colour], axis=0)
    side = np.max([y.max(axis=1) for _, y, _, _, _ in per_colour], axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    stretch = np.sqrt(
        np.max(
            [
                (((x - middle[:, None]) / half[:, None]) ** 2 + (y / side[:, None]) ** 2).max(
                    axis=1
                )
                for x, y, _, _, _ in per_colour
            ],
            axis=0,
        )
    )
    # A percent of room for radii and wavelengths between those of the tables.
    outlines = [one[3] for one in per_colour]
    return Field(
        radius_m=radius,
        crossing_m=crossing,
        slope=slope,
        etendue=np.stack([one[2] for one in per_colour], axis=1),
        centre_m=middle,
        half_x_m=1.01 * stretch * half,
        half_y_m=1.01 * stretch * side,
        outline=tuple(np.stack(parts, axis=1) for parts in zip(*outlines, strict=True)),  # type: ignore[arg-type]
        centroid=(
            np.stack([one[4][0] for one in per_colour], axis=1),
            np.stack([one[4][1] for one in per_colour], axis=1),
        ),
    )


def _aimed(lens: Mounted, radius: Array, pupil_x: Array, pupil_y: Array, nm: Array) -> Rays:
    """Rays from image points at (-radius, 0) through points of the exit pupil, before the lens."""
    x, y, z = pupil_x + radius, pupil_y, np.full_like(pupil_x, lens.exit_pupil_m - lens.detector_m)
    # A pupil behind the detector is aimed at backwards.
    length = np.sqrt(x**2 + y**2 + z**2) * -np.sign(z)
    start = Rays(
        x=-radius + 0 * x,
        y=0 * x,
        z=lens.detector_m + 0 * x,
        dx=x / length,
        dy=y / length,
        dz=z / length,
        alive=np.ones(np.shape(x), dtype=bool),
    )
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        return trace(lens, start, lens.indices(nm))


def _chief(lens: Mounted, radius: Array, nm: Array) -> Array:
    """Where in the plane of the exit pupil the ray through the middle of the stop passes."""

    def at_stop(pupil: Array) -> Array:
        part = _only_behind_stop(lens)
        return np.asarray(_aimed(part, radius, pupil, np.zeros_like(radius), nm).x)

    low, high = np.zeros_like(radius), np.full_like(radius, 0.05 * lens.exit_pupil_radius_m)
    first, second = at_stop(low), at_stop(high)
    for _ in range(12):
        step = np.divide(high - low, second - first, out=np.zeros_like(low), where=second != first)
        low, first, high = high, second, high - second * step
        second = at_stop(high)
    return high


def _only_behind_stop(lens: Mounted) -> Mounted:
    """The lens from the stop on, with rims that stop nothing."""
    keep = slice(lens.stop, None)
    return Mounted(
        vertex_m=lens.vertex_m[keep],
        rim_m=np.full(len(lens.surfaces) - lens.stop, 1e3),
        curvature_per_m=lens.curvature_per_m[keep],
        conic=lens.conic[keep],
        aspheric=lens.aspheric[keep],
        ideal_focal_m=lens.ideal_focal_m[keep],
        surfaces=lens.surfaces[keep],
        stop=0,
        detector_m=lens.detector_m,
        exit_pupil_m=lens.exit_pupil_m,
        exit_pupil_radius_m=lens.exit_pupil_radius_m,
        entrance_pupil_m=lens.entrance_pupil_m,
    )


def _open(
    lens: Mounted, radius: Array, centre: Array, colour: float
) -> tuple[Array, Array, Array, tuple[Array, Array, Array, Array], tuple[Array, Array]]:
    """Outline x, y (R, A), etendue (R,), the outline's rays in the scene, and the centroid's."""
    angle = (np.arange(AROUND) + 0.5) * math.pi / AROUND
    cos, sin = np.cos(angle)[None, :], np.sin(angle)[None, :]
    image = np.broadcast_to(radius[:, None], (radius.size, AROUND))
    nm = np.array([colour])
    low = np.zeros(image.shape)
    high = np.full(image.shape, WIDEST * lens.exit_pupil_radius_m)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        alive = _aimed(lens, image, centre[:, None] + middle * cos, middle * sin, nm).alive
        low, high = np.where(alive, middle, low), np.where(alive, high, middle)
    rays = _aimed(lens, image, centre[:, None] + low * cos, low * sin, nm)
    outline = _in_scene(rays)
    at, weight = np.polynomial.legendre.leggauss(RINGS)
    part, share = (at + 1) / 2, weight / 2
    reach = lens.detector_m - lens.exit_pupil_m
    rho = low[..., None] * part
    x, y = centre[:, None, None] + rho * cos[..., None], rho * sin[..., None]
    d2 = (x + image[..., None]) ** 2 + y**2 + reach**2
    weights = share * rho * low[..., None] * reach**2 / d2**2 * 2 * math.pi / AROUND
    etendue = weights.sum(axis=(1, 2))
    shape = x.shape
    inner = _in_scene(
        _aimed(lens, np.broadcast_to(image[..., None], shape).ravel(), x.ravel(), y.ravel(), nm)
    )
    centroid = tuple(
        (values.reshape(shape) * weights).sum(axis=(1, 2)) / etendue for values in inner[::2]
    )
    return (
        centre[:, None] + low * cos,
        low * sin + 0 * image,
        etendue,
        outline,
        centroid,
    )


def _in_scene(rays: Rays) -> tuple[Array, Array, Array, Array]:
    """x, y at the first principal plane and the slopes towards the scene."""
    sx, sy = -rays.dx / rays.dz, -rays.dy / rays.dz
    return rays.x + sx * rays.z, rays.y + sy * rays.z, sx, sy
