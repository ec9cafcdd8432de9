"""Lens prescriptions as data: surfaces, glasses, rims, and what paraxial optics says of them.

Surfaces stand in the order of light, from the scene to the detector, lengths in any one unit: a
scene scales them to its focal length. Paraxial quantities are those of matrices (y, u) after
W. J. Smith, Modern Optical Engineering, 4th ed., ch. 2 to 4.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from foundation.documents import STRICT, read_toml
from foundation.errors import unknown
from scenes.errors import SceneError
from scenes.lamp import Positive
from scenes.lens import Lens

Array = NDArray[np.float64]

F_NM, D_NM, C_NM = 486.13, 587.56, 656.27
"""Fraunhofer's lines, in which Abbe numbers are given."""


@dataclass(frozen=True, kw_only=True)
class Surface:
    """One surface, and what follows it on the way to the detector.

    Attributes:
        radius: of curvature, positive with its centre towards the detector; 0 is flat.
        thickness: along the axis to the next surface; of the last one whatever one likes.
        rim: half of the free diameter.
        index: refractive index behind it at 587.56 nm (d); 1 is air.
        abbe: Abbe number of that glass.
        sellmeier: in place of index and abbe: B1, C1, B2, C2, B3, C3 with C in square micrometres.
        conic: 0 is a sphere, -1 a parabola.
        aspheric: coefficients of r^4, r^6, r^8 and so on in the sagitta.
        stop: whether this is the aperture stop, whose rim the f-number sets.
        ideal_focal_length: of an ideal thin lens in place of a refracting surface, for tests.
    """

    radius: float = 0.0
    thickness: Annotated[float, Field(ge=0)]
    rim: Positive
    index: Annotated[float, Field(ge=1, le=3)] = 1.0
    abbe: Positive | None = None
    sellmeier: tuple[float, float, float, float, float, float] | None = None
    conic: float = 0.0
    aspheric: tuple[float, ...] = ()
    stop: bool = False
    ideal_focal_length: float | None = None

    __pydantic_config__ = STRICT

    def index_at(self, nm: Array) -> Array:
        """The index behind the surface: Sellmeier's formula, or Cauchy's two terms that fit the
        index at d and the Abbe number.
        """
        if self.sellmeier is not None:
            b, c = self.sellmeier[::2], self.sellmeier[1::2]
            um2 = (nm / 1e3) ** 2
            return np.sqrt(1 + sum(x * um2 / (um2 - y) for x, y in zip(b, c, strict=True)))
        if self.abbe is None:
            return np.full_like(nm, self.index)
        slope = (self.index - 1) / self.abbe / (F_NM**-2 - C_NM**-2)
        return np.asarray(self.index + slope * (nm**-2 - D_NM**-2))


@dataclass(frozen=True, kw_only=True)
class Prescription:
    """A lens.

    Attributes:
        name, source: what it is and where its figures are from.
        focal_length: what the source says it is, in the unit of the surfaces.
        surface: in the order of light.
    """

    name: str
    source: str
    focal_length: Positive
    surface: Annotated[tuple[Surface, ...], Field(min_length=2)]

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True, eq=False)
class Mounted:
    """A prescription scaled to a scene's lens and put in its place, lengths in m.

    Positions count along the light from the first principal plane; the detector stands at
    `detector_m`, where the lens is focused by the thin lens equation.
    """

    vertex_m: Array
    rim_m: Array
    curvature_per_m: Array
    conic: Array
    aspheric: tuple[tuple[float, ...], ...]
    ideal_focal_m: tuple[float | None, ...]
    surfaces: tuple[Surface, ...]
    stop: int
    detector_m: float
    exit_pupil_m: float
    exit_pupil_radius_m: float
    entrance_pupil_m: float

    def indices(self, nm: Array) -> list[Array]:
        """The index behind each surface, after that before the first."""
        return [*(surface.index_at(nm) for surface in self.surfaces), np.ones_like(nm)]


def prescription_names() -> list[str]:
    """The prescriptions that come with the package."""
    folder = resources.files("scenes") / "lenses"
    return sorted(p.name[:-5] for p in folder.iterdir() if p.name.endswith(".toml"))


def load_prescription(name: str) -> Prescription:
    """A prescription by name or by the path of a TOML file.

    Raises:
        SceneError: for an unknown name, or not exactly one stop.
        DocumentError: for a file that is not a prescription.
    """
    if name in prescription_names():
        path = Path(str(resources.files("scenes") / "lenses" / f"{name}.toml"))
    elif name.endswith(".toml"):
        path = Path(name)
    else:
        raise unknown("lens prescription", name, prescription_names(), SceneError)
    result = read_toml(path, Prescription)
    stops = sum(surface.stop for surface in result.surface)
    if stops != 1:
        raise SceneError(f"{path} has {stops} stops", "expected one", "mark one surface as stop")
    return result


def matrix(surfaces: tuple[Surface, ...], nm: float = D_NM) -> Array:
    """The paraxial matrix (y, u) from before the first surface to behind the last."""
    result, before = np.eye(2), 1.0
    for number, surface in enumerate(surfaces):
        behind = float(surface.index_at(np.array(nm)))
        if surface.ideal_focal_length is not None:
            bend = np.array([[1, 0], [-1 / surface.ideal_focal_length, 1]])
        else:
            power = (behind - before) / surface.radius if surface.radius else 0.0
            bend = np.array([[1, 0], [-power / behind, before / behind]])
        go = np.array([[1, surface.thickness if number < len(surfaces) - 1 else 0.0], [0, 1]])
        result, before = go @ bend @ result, behind
    return result


def mount(prescription: Prescription, lens: Lens) -> Mounted:
    """A prescription in its place behind a scene's first principal plane; see `Mounted`.

    Raises:
        SceneError: for a lens that does not focus, or a stop wider than its rim.
    """
    surfaces = prescription.surface
    whole = matrix(surfaces)
    if whole[1, 0] >= 0:
        raise SceneError(
            f"lens '{prescription.name}' has no positive focal length",
            "expected a lens that forms an image",
            "correct its surfaces",
        )
    focal = -1 / whole[1, 0]
    scale = lens.focal_length_mm * 1e-3 / focal
    vertex = np.concatenate([[0.0], np.cumsum([s.thickness for s in surfaces[:-1]])])
    front = whole[1, 1] / whole[1, 0] + focal
    rear = vertex[-1] - whole[0, 0] / whole[1, 0] - focal
    stop = next(n for n, surface in enumerate(surfaces) if surface.stop)
    ahead, after = matrix(surfaces[: stop + 1]), matrix(surfaces[stop:])
    radius = focal / (2 * lens.f_number) * abs(ahead[0, 0])
    if radius > surfaces[stop].rim * (1 + 1e-9):
        raise SceneError(
            f"f_number = {lens.f_number:g} of lens '{prescription.name}'",
            f"expected at least {lens.f_number * radius / surfaces[stop].rim:.3g}, where the stop"
            " fills its rim",
            "increase f_number",
        )
    rims = np.array([surface.rim for surface in surfaces])
    rims[stop] = radius
    detector = rear * scale + lens.image_distance_m - front * scale
    pupil = vertex[-1] - after[0, 1] / after[1, 1]
    enters = -ahead[0, 1] / ahead[0, 0]
    return Mounted(
        vertex_m=(vertex - front) * scale,
        rim_m=rims * scale,
        curvature_per_m=np.array([1 / s.radius / scale if s.radius else 0.0 for s in surfaces]),
        conic=np.array([surface.conic for surface in surfaces]),
        aspheric=tuple(
            tuple(a * scale ** -(2 * n + 3) for n, a in enumerate(s.aspheric)) for s in surfaces
        ),
        ideal_focal_m=tuple(
            None if s.ideal_focal_length is None else s.ideal_focal_length * scale for s in surfaces
        ),
        surfaces=surfaces,
        stop=stop,
        detector_m=detector,
        exit_pupil_m=(pupil - front) * scale,
        exit_pupil_radius_m=abs(radius / after[1, 1]) * scale,
        entrance_pupil_m=(-enters - front) * scale,
    )


@functools.lru_cache(maxsize=16)
def mounted(lens: Lens) -> Mounted:
    """The prescription that a real lens names, in its place.

    Raises:
        SceneError: for an unknown prescription, or one that cannot be.
    """
    assert lens.prescription is not None
    return mount(load_prescription(lens.prescription), lens)
