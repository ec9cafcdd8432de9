"""A lamp as data: what it is, where it stands, and what colour it shines in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from foundation.documents import NAME, STRICT

Positive = Annotated[float, Field(gt=0)]
Fraction = Annotated[float, Field(gt=0, le=1)]
Name = Annotated[str, NAME]
Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Filter:
    """A gel in front of a lamp that brings its colour nearer to the camera's liking.

    The transmission is that of two ideal gels on top of each other, scaled so that its highest
    value from 400 to 700 nm is `peak_transmission`: a colour conversion gel, which multiplies by
    exp(-c2 M / wavelength) and so moves a black body by M = `mired_shift` (negative: bluer;
    Wien's law), and a magenta gel with the optical density `green_density` at 540 nm and a
    Gaussian band of 40 nm standard deviation (negative: a green gel).
    """

    mired_shift: Annotated[float, Field(ge=-500, le=500)]
    green_density: Annotated[float, Field(ge=-2, le=2)]
    peak_transmission: Fraction = 0.9

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Lamp:
    """A source of light: a point, a matt disk, or a thin matt tube.

    ``point``
        shines equally in all directions, or as an IES file says.
    ``disk``
        a flat disk that faces `aim_m` and is equally bright from all sides: cosine law.
    ``tube``
        a line along `axis` each part of which shines as the sine of the angle from the axis, as
        a matt tube does from afar. Its thickness is neglected; docs/light.md says what that costs.

    Attributes:
        name: what a protocol calls it.
        kind: ``point``, ``disk`` or ``tube``.
        spd: name of a spectrum of colour-science, or the path of a CSV file ``nm,value``.
        temperature_k: in place of `spd`: a black body of that temperature (Planck's law).
        position_m: x, y, z of its middle in m.
        intensity_w_per_sr: radiant intensity from 400 to 700 nm in W/sr at level 1, before the
            gel: of a disk along its axis, of a tube square to its axis, with an IES file in the
            direction in which it is brightest.
        aim_m: the point that a disk faces and to which the axis of an IES file points.
        diameter_m: of a disk.
        length_m, axis: of a tube: its length, and the direction in which it lies.
        ies: path of an IES file (LM-63) with the angular distribution of a point.
        filter: the gel, if there is one.
        note: what is assumed about it.
    """

    name: Name
    kind: Literal["point", "disk", "tube"] = "point"
    spd: str | None = None
    temperature_k: Annotated[float, Field(ge=1000, le=25000)] | None = None
    position_m: Point
    intensity_w_per_sr: Positive
    aim_m: Point = (0.0, 0.0, 0.0)
    diameter_m: Positive | None = None
    length_m: Positive | None = None
    axis: Point = (1.0, 0.0, 0.0)
    ies: str | None = None
    filter: Filter | None = None
    note: str = ""

    __pydantic_config__ = STRICT
