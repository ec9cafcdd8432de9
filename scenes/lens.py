"""A lens as data: an ideal thin one, or one traced surface by surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from foundation.documents import STRICT
from scenes.lamp import Fraction, Positive


@dataclass(frozen=True, kw_only=True)
class Barrel:
    """The round front opening of the lens mount, which cuts oblique light (vignetting).

    Attributes:
        radius_mm: radius of the opening.
        distance_mm: from the aperture towards the scene.
    """

    radius_mm: Positive
    distance_mm: Positive

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Lens:
    """A lens with a round aperture.

    ``thin``
        all of it in one plane, free of aberrations.
    ``real``
        glass surfaces after a prescription, scaled to the focal length; distances count from its
        principal planes, so that it is the thin lens near its axis.

    Attributes:
        kind: ``thin`` or ``real``.
        prescription: of a real lens: a name in scenes/lenses/, or a TOML file.
        focal_length_mm: focal length.
        f_number: focal length over the diameter of the beam that enters on the axis.
        focus_distance_m: from the lens to what is sharp; the chart is meant not to be.
        transmission: part of the light that passes the glass.
        barrel: the front opening of a thin lens, if it is to cut light; a real lens has rims.
    """

    kind: Literal["thin", "real"] = "thin"
    prescription: str | None = None
    focal_length_mm: Positive
    f_number: Positive
    focus_distance_m: Positive
    transmission: Fraction = 1.0
    barrel: Barrel | None = None

    __pydantic_config__ = STRICT

    @property
    def aperture_radius_m(self) -> float:
        """Radius of the aperture in m; of a real lens, that of the beam that enters on the axis."""
        return self.focal_length_mm * 1e-3 / (2 * self.f_number)

    @property
    def image_distance_m(self) -> float:
        """From the lens to the detector in m, by the thin lens equation at the focus distance."""
        focal_length_m = self.focal_length_mm * 1e-3
        return 1 / (1 / focal_length_m - 1 / self.focus_distance_m)
