"""A real lens as the renderer's camera: a point of the detector and two random numbers to a ray.

Points of the exit pupil are drawn from the ellipse that holds the open pupil of that image radius
(`scenes.field`), so that few rays are lost at the rims; the ray's weight is what the pupil point
stands for, cos^4 / l^2 times the area of the ellipse. No Mitsuba here: arrays are whatever the
functions of `Dr` make of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.field import Field
from scenes.prescription import Mounted
from scenes.ray_trace import Maths, Rays, trace

Array = NDArray[np.float64]

INDEX_NM = np.linspace(380.0, 780.0, 201)
"""Grid on which refractive indices are tabulated for the renderer: linear to 1e-6."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pupils:
    """Tables that the renderer looks up: pupil ellipses by image radius, indices by wavelength.

    Attributes:
        radius_m: the last of the image radii, which rise evenly from 0.
        ellipse: centre, half width, half height and area of each, (R, 4).
        indices: behind each surface and before the first, (N + 1, INDEX_NM).
        on_axis: etendue at the centre of the detector, to which weights are relative.
    """

    radius_m: float
    ellipse: Array
    indices: Array
    on_axis: float


def pupils(lens: Mounted, field: Field) -> Pupils:
    """The tables of a lens."""
    area = math.pi * field.half_x_m * field.half_y_m
    return Pupils(
        radius_m=float(field.radius_m[-1]),
        ellipse=np.stack([field.centre_m, field.half_x_m, field.half_y_m, area], axis=1),
        indices=np.stack(lens.indices(INDEX_NM)),
        on_axis=float(field.etendue[0].mean()),
    )


def leave(
    lens: Mounted,
    tables: Pupils,
    place: tuple[Any, Any],
    disk: tuple[Any, Any],
    ellipse: list[Any],
    indices: list[Any],
    maths: Maths,
) -> tuple[Rays, Any]:
    """Rays from upright image places (right, up, in m) into the scene, and their weights.

    Args:
        lens, tables: the lens.
        place: on the detector, as the picture shows it.
        disk: points of the unit disk.
        ellipse: the pupil of each place, from the tables.
        indices: of each ray, as `Mounted.indices`.
        maths: see `ray_trace`.
    """
    right, up = place
    radius = maths.sqrt(right * right + up * up)
    inverse = 1 / maths.select(radius > 0, radius, 1.0)
    cos, sin = maths.select(radius > 0, right * inverse, 1.0), up * inverse
    centre, half_x, half_y, area = ellipse
    away, aside = centre + half_x * disk[0], half_y * disk[1]
    pupil_x, pupil_y = away * cos - aside * sin, away * sin + aside * cos
    # The image is upside down: what the picture shows to the right lies to the left.
    reach = lens.detector_m - lens.exit_pupil_m
    dx, dy = pupil_x + right, pupil_y + up
    squared = dx * dx + dy * dy + reach * reach
    length = maths.sqrt(squared) * (1.0 if reach > 0 else -1.0)
    start = Rays(
        x=-right,
        y=-up,
        z=0 * right + lens.detector_m,
        dx=dx / length,
        dy=dy / length,
        dz=-reach / length,
        alive=squared > 0,
    )
    weight = area * reach * reach / (squared * squared) / tables.on_axis
    return trace(lens, start, indices, maths), weight
