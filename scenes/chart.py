"""What is photographed, as data: a chart of one of four patterns, matt or glossy, tilted or not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag

from foundation.documents import STRICT
from scenes.lamp import Positive

Reflectance = Annotated[float, Field(ge=0, le=1)]
Reflectances = Annotated[
    Annotated[str, Tag("name")] | Annotated[tuple[Reflectance, ...], Tag("figures")],
    Discriminator(lambda value: "name" if isinstance(value, str) else "figures"),
]
Tilt = Annotated[float, Field(ge=-60, le=60)]


@dataclass(frozen=True, kw_only=True)
class Gloss:
    """A clear coat on the panels: a rough dielectric (Beckmann) over the matt colour.

    Attributes:
        roughness: root mean square slope of its surface, times the square root of 2.
        index: refractive index.
    """

    roughness: Annotated[float, Field(ge=0.02, le=0.7)]
    index: Annotated[float, Field(gt=1.0, le=2.5)] = 1.5

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A flat card with panels on it.

    ``checker``
        a ColorChecker: 24 square panels of `panel_m` in 4 rows of 6, named "1" to "24".
    ``uniform``
        the whole card is one panel "1".
    ``edge``
        panels "dark" and "bright", between them a straight edge `edge_deg` off the vertical.
    ``wedge``
        grey strips of the card's height from left to right, named "1", "2" and so on.

    Attributes:
        pattern: one of the four.
        reflectances: for a checker the name of a chart of colour-science, or of a CSV file
            ``nm,1,...,24``; for the others one figure for each panel.
        width_m, height_m: size of the card in m.
        panel_m: side of a panel of the checker in m.
        gap_m: card between two panels in m.
        edge_deg: see above.
        frame_reflectance: reflectance of the card, equal at all wavelengths.
        tilt_deg: turn about the horizontal axis of the card (its top comes nearer), then about
            the vertical (its left side comes nearer), in degrees.
        gloss: the coat of the panels, if they have one; the card is matt.
    """

    pattern: Literal["checker", "uniform", "edge", "wedge"] = "checker"
    reflectances: Reflectances
    width_m: Positive
    height_m: Positive
    panel_m: Positive | None = None
    gap_m: Annotated[float, Field(ge=0)] = 0.0
    edge_deg: Annotated[float, Field(ge=1, le=30)] = 5.0
    frame_reflectance: Reflectance
    tilt_deg: tuple[Tilt, Tilt] = (0.0, 0.0)
    gloss: Gloss | None = None

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Booth:
    """What stands around the chart and throws light back on it, when bounces are asked for.

    A table below and a wall on either side, matt and grey, from the wall behind the chart towards
    the camera; open above and in front. They are out of the picture, and are not there at all in a
    rendering of direct light.

    Attributes:
        width_m: from side wall to side wall.
        floor_m: from the centre of the chart down to the table.
        depth_m: from the plane of the chart to the front of table and walls.
        height_m: from the table up to the top of the walls.
        reflectance: of the table and the walls.
    """

    width_m: Positive
    floor_m: Positive
    depth_m: Positive
    height_m: Positive
    reflectance: Reflectance

    __pydantic_config__ = STRICT
