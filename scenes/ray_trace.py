"""Rays through a real lens, from the detector towards the scene: refraction by refraction.

The same lines trace NumPy arrays here and Dr.Jit arrays in the renderer: `Maths` holds the two
functions whose names differ. Positions are x, y across and z along the light, from the first
principal plane as in `Mounted`; rays run against the light, towards smaller z.

    intersection   conic sections in closed form, aspheric terms by Newton's method
    refraction     n1 sin i1 = n2 sin i2 as vectors: G. H. Spencer, M. V. R. K. Murty, J. Opt. Soc.
                   Am. 52, 672 (1962)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenes.prescription import Mounted

NEWTON_STEPS = 4
"""From the conic section on; each squares the error."""


@dataclass(frozen=True, kw_only=True)
class Maths:
    """Square root, and the choice between two values."""

    sqrt: Callable[[Any], Any]
    select: Callable[[Any, Any, Any], Any]


NUMPY = Maths(sqrt=np.sqrt, select=np.where)


@dataclass(frozen=True, kw_only=True, eq=False)
class Rays:
    """Positions and unit directions in m, and which rays still run."""

    x: Any
    y: Any
    z: Any
    dx: Any
    dy: Any
    dz: Any
    alive: Any


def trace(lens: Mounted, rays: Rays, indices: Sequence[Any], maths: Maths = NUMPY) -> Rays:
    """Rays behind the lens to rays before it; `indices` as from `Mounted.indices`."""
    for number in reversed(range(len(lens.surfaces))):
        rays = _through(lens, number, rays, indices[number], indices[number - 1], maths)
    return rays


def _through(
    lens: Mounted, number: int, rays: Rays, behind: Any, before: Any, maths: Maths
) -> Rays:
    """One surface, from the side of the detector."""
    curvature, conic = float(lens.curvature_per_m[number]), 1 + float(lens.conic[number])
    terms, vertex, rim = lens.aspheric[number], float(lens.vertex_m[number]), lens.rim_m[number]
    x, y, z = rays.x, rays.y, rays.z - vertex
    dx, dy, dz, alive = rays.dx, rays.dy, rays.dz, rays.alive
    if curvature == 0.0:
        far = -z / dz
    else:
        a = curvature * (dx * dx + dy * dy + conic * dz * dz)
        b = curvature * (x * dx + y * dy + conic * z * dz) - dz
        c = curvature * (x * x + y * y + conic * z * z) - 2 * z
        inside = b * b - a * c
        alive = alive & (inside >= 0)
        far = c / (-b - maths.sqrt(maths.select(inside >= 0, inside, 1.0)))
    for _ in range(NEWTON_STEPS if terms else 0):
        px, py, pz = x + far * dx, y + far * dy, z + far * dz
        sag, slope = _sagitta(px * px + py * py, curvature, conic, terms, maths)
        far = far - (pz - sag) / (dz - slope * (px * dx + py * dy))
    x, y, z = x + far * dx, y + far * dy, z + far * dz
    r2 = x * x + y * y
    alive = alive & (r2 <= float(rim) ** 2)
    focal = lens.ideal_focal_m[number]
    if focal is not None:
        sx, sy = dx / dz + x / focal, dy / dz + y / focal
        length = -1 / maths.sqrt(1 + sx * sx + sy * sy)
        dx, dy, dz = sx * length, sy * length, length
    elif lens.surfaces[number].stop and curvature == 0.0:
        pass
    else:
        if terms:
            slope = _sagitta(r2, curvature, conic, terms, maths)[1]
            nx, ny, nz = slope * x, slope * y, -1.0
        else:
            nx, ny, nz = curvature * x, curvature * y, curvature * conic * z - 1
        # The normal points against z, as the rays do.
        norm = 1 / maths.sqrt(nx * nx + ny * ny + nz * nz)
        nx, ny, nz = nx * norm, ny * norm, nz * norm
        ratio = behind / before
        cosine = dx * nx + dy * ny + dz * nz
        root = 1 - ratio * ratio * (1 - cosine * cosine)
        alive = alive & (root >= 0)
        shift = maths.sqrt(maths.select(root >= 0, root, 1.0)) - ratio * cosine
        dx, dy, dz = ratio * dx + shift * nx, ratio * dy + shift * ny, ratio * dz + shift * nz
    return Rays(x=x, y=y, z=z + vertex, dx=dx, dy=dy, dz=dz, alive=alive)


def _sagitta(
    r2: Any, curvature: float, conic: float, terms: tuple[float, ...], maths: Maths
) -> tuple[Any, Any]:
    """Depth of an aspheric surface at a squared radius, and its slope over the radius."""
    inside = 1 - conic * curvature * curvature * r2
    root = maths.sqrt(maths.select(inside > 0, inside, 1.0))
    depth, slope, power = curvature * r2 / (1 + root), curvature / root, r2
    for order, term in enumerate(terms, start=2):
        slope = slope + 2 * order * term * power
        power = power * r2
        depth = depth + term * power
    return depth, slope
