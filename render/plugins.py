"""Two plugins in Python for Mitsuba's variants with a just-in-time compiler.

A lamp of many points that every path asks in full, and a camera that traces a real lens. Mitsuba is
handed in: `path_traced` alone imports it.
"""

from __future__ import annotations

import functools
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from render.real_lens import INDEX_NM, leave, pupils
from render.stage import MM_PER_M
from scenes.imaging import real_field
from scenes.prescription import mounted
from scenes.ray_trace import Maths
from scenes.scene import Scene

Array = NDArray[np.float64]

EVERY_LAMP, TRACED_LENS = "every_lamp", "traced_lens"
MATHS = Maths(sqrt=dr.sqrt, select=dr.select)

_LENSES: dict[int, tuple[Scene, Array, Array, bool]] = {}
"""What a camera is made of: Mitsuba hands numbers to a plugin, but no objects of ours."""


def remember(scene: Scene, ends_nm: Array, true_nm: Array, one_wavelength: bool) -> int:
    """Keep what the next cameras are made of, under a number."""
    key = len(_LENSES)
    _LENSES[key] = (scene, ends_nm, true_nm, one_wavelength)
    return key


def forget() -> None:
    """Let go of what was remembered, once the cameras are made."""
    _LENSES.clear()


@functools.cache
def register(mi: Any, variant: str) -> None:
    """Make the plugins known to one variant of Mitsuba, which is the current one."""
    mi.register_integrator(EVERY_LAMP, _every_lamp(mi))
    mi.register_sensor(TRACED_LENS, _traced_lens(mi))


def _every_lamp(mi: Any) -> Any:
    """An integrator for direct light that asks every lamp of the scene."""

    class EveryLamp(mi.SamplingIntegrator):  # type: ignore[misc]
        """Direct light of all lamps, none left to chance; the glow of what is met besides."""

        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> tuple[Any, Any, list[Any]]:
            met = scene.ray_intersect(ray, active)
            valid = active & met.is_valid()
            light = mi.Spectrum(met.emitter(scene).eval(met, valid))
            surface, context = met.bsdf(ray), mi.BSDFContext()
            for lamp in scene.emitters():
                if not mi.has_flag(lamp.flags(), mi.EmitterFlags.DeltaPosition):
                    continue
                towards, weight = lamp.sample_direction(met, mi.Point2f(0.5), valid)
                asks = valid & dr.any(weight != 0)
                hidden = scene.ray_test(met.spawn_ray_to(towards.p), asks)
                seen = surface.eval(context, met, met.to_local(towards.d), asks)
                light += dr.select(asks & ~hidden, weight * seen, 0)
            return light, valid, []

    return lambda properties: EveryLamp(properties)


def _traced_lens(mi: Any) -> Any:
    """A sensor that traces a real lens."""

    def table(values: Array) -> Any:
        return mi.Float(np.ascontiguousarray(values.ravel(), dtype=np.float32))

    def look_up(values: Any, cell: Any, part: Any, size: int, row: int) -> Any:
        low = dr.gather(mi.Float, values, cell + row * size)
        return dr.lerp(low, dr.gather(mi.Float, values, cell + row * size + 1), part)

    def cell_of(position: Any, size: int) -> tuple[Any, Any]:
        cell = dr.clip(mi.UInt32(position), 0, size - 2)
        return cell, position - mi.Float(cell)

    class TracedLens(mi.Sensor):  # type: ignore[misc]
        """Rays from the film through a prescription; see `real_lens`."""

        def __init__(self, properties: Any) -> None:
            super().__init__(properties)
            scene, ends_nm, true_nm, self.one_wavelength = _LENSES[int(properties["key"])]
            known = real_field(scene)
            assert known is not None
            self.lens = mounted(scene.lens)
            self.pupils = pupils(self.lens, known)
            self.distance_m = scene.camera_distance_m
            pitch_m = scene.detector.pitch_um * 1e-6
            self.size_m = scene.detector.width_px * pitch_m, scene.detector.height_px * pitch_m
            self.ends_nm, self.colours = ends_nm, true_nm.size
            self.true_nm = table(true_nm)
            self.radii = len(self.pupils.ellipse)
            self.ellipses = table(self.pupils.ellipse.T)
            self.indices = table(self.pupils.indices)
            self.m_needs_sample_3 = True

        def sample_ray(
            self, time: Any, colour: Any, position: Any, aperture: Any, active: Any = True
        ) -> tuple[Any, Any]:
            wavelengths, weight = self.sample_wavelengths(
                dr.zeros(mi.SurfaceInteraction3f), colour, active
            )
            first = wavelengths[0]
            if self.one_wavelength:
                wavelengths = type(wavelengths)(first)
                weight = type(weight)(weight[0])
            low, high = (float(nm) for nm in self.ends_nm)
            cell, part = cell_of((first - low) / (high - low) * (self.colours - 1), self.colours)
            nm = look_up(self.true_nm, cell, part, self.colours, 0)
            step = float(INDEX_NM[1] - INDEX_NM[0])
            cell, part = cell_of((nm - float(INDEX_NM[0])) / step, INDEX_NM.size)
            count = len(self.lens.surfaces) + 1
            indices = [look_up(self.indices, cell, part, INDEX_NM.size, n) for n in range(count)]
            right = (position.x - 0.5) * self.size_m[0]
            up = (0.5 - position.y) * self.size_m[1]
            along = dr.sqrt(right * right + up * up) / self.pupils.radius_m * (self.radii - 1)
            cell, part = cell_of(along, self.radii)
            ellipse = [look_up(self.ellipses, cell, part, self.radii, n) for n in range(4)]
            point = mi.warp.square_to_uniform_disk_concentric(aperture)
            rays, share = leave(
                self.lens, self.pupils, (right, up), (point.x, point.y), ellipse, indices, MATHS
            )
            alive = rays.alive & active
            origin = mi.Point3f(rays.x, rays.y, rays.z + self.distance_m) * MM_PER_M
            direction = mi.Vector3f(rays.dx, rays.dy, rays.dz)
            ray = mi.Ray3f(
                dr.select(alive, origin, mi.Point3f(0, 0, self.distance_m * MM_PER_M)),
                dr.select(alive, dr.normalize(direction), mi.Vector3f(0, 0, -1)),
                time,
                wavelengths,
            )
            return ray, weight * dr.select(alive, share, 0.0)

        def sample_ray_differential(
            self, time: Any, colour: Any, position: Any, aperture: Any, active: Any = True
        ) -> tuple[Any, Any]:
            ray, weight = self.sample_ray(time, colour, position, aperture, active)
            return mi.RayDifferential3f(ray), weight

    return lambda properties: TracedLens(properties)
