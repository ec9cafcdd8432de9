"""The families of statistics, and the stage where a gap in each most often begins."""

from __future__ import annotations

from collections.abc import Callable

from analysis.gap.look.statistics.codes import codes
from analysis.gap.look.statistics.group import Figures, Group
from analysis.gap.look.statistics.pattern import pattern, pattern_lines, pattern_shape
from analysis.gap.look.statistics.spectrum import spectrum
from analysis.gap.look.statistics.structure import columns, frames, neighbours, rows, tails, time
from analysis.gap.look.statistics.surface import surface
from analysis.gap.look.statistics.transfer import level, transfer
from analysis.gap.look.texture import FAMILY as TEXTURE
from analysis.gap.look.texture import STAGE as STAGE_OF_TEXTURE

NEIGHBOURS = "neighbours"

FAMILIES: dict[str, tuple[Callable[[Group], Figures], str]] = {
    "level": (level, "readout"),
    "transfer": (transfer, "photosite"),
    "rows": (rows, "readout"),
    "columns": (columns, "readout"),
    "frames": (frames, "lighting"),
    NEIGHBOURS: (neighbours, "processing"),
    "time": (time, "processing"),
    "tails": (tails, "photosite"),
    "spectrum": (spectrum, "readout"),
    "codes": (codes, "adc"),
    "pattern": (pattern, "photosite"),
    "pattern lines": (pattern_lines, "readout"),
    "pattern shape": (pattern_shape, "photosite"),
    "dark surface": (surface, "photosite"),
}
"""Every family of one lattice, and the stage where a gap in it most often begins."""

INTERPOLATION = "interpolation"
GREENS = "greens"
IMAGE = "mean image"
STAGES = {name: stage for name, (_, stage) in FAMILIES.items()} | {
    INTERPOLATION: "processing",
    GREENS: "photosite",
    IMAGE: "optics",
    TEXTURE: STAGE_OF_TEXTURE,
}

OF_A_BODY = frozenset(
    {
        "level",
        "codes",
        "pattern",
        "pattern lines",
        "pattern shape",
        "dark surface",
        TEXTURE,
        GREENS,
    }
)
"""Families of what stays from frame to frame: more frames do not average a camera body away."""

EVERY_SHOT = "every shot"
REPEATED = "repeated frames"
REPEATED_IN_PART = "repeated rows"
"""Statistics of all shots together, of the family of time: shares of the frames that repeat the one
before, and of those that repeat rows of it."""

OTHERWISE = {"repeated": "transport", "grid of 8": "transport", "kurtosis": "readout"}
"""Beginnings of the names of statistics, and the stage where a gap in each most often begins where
that is not the stage of its family."""


def stage_of(family: str, statistic: str, *, lit: bool) -> str:
    """The stage where a gap in a statistic most often begins.

    Args:
        family, statistic: its names.
        lit: whether it is of a shot under a lamp. What is left of a picture there was left of the
            light more often than of photosites.
    """
    if lit and family == TEXTURE:
        return STAGES[IMAGE]
    found = (stage for name, stage in OTHERWISE.items() if statistic.startswith(name))
    return next(found, STAGES[family])
