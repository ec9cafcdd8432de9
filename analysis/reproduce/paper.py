"""What the paper prints, as data, and a line of comparison with what we find."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from foundation.documents import STRICT, read_toml

CLEAR = 3.0
"""Standard errors beyond what the printed digits allow, from which we say that figures differ."""


@dataclass(frozen=True, kw_only=True)
class Printed:
    """A printed figure, or one for each channel.

    Attributes:
        key: what we call it.
        place: where it stands in the paper.
        what: what it is.
        unit: its unit.
        decimals: printed digits after the point.
        value: by channel; ``all`` where it has none.
    """

    key: str
    place: str
    what: str
    unit: str
    decimals: Annotated[int, Field(ge=0, le=6)]
    value: dict[str, float]

    __pydantic_config__ = STRICT


@dataclass(frozen=True, kw_only=True)
class Paper:
    """All of them, in the paper's order."""

    printed: tuple[Printed, ...] = field(default=())

    __pydantic_config__ = STRICT


@functools.cache
def printed() -> Mapping[str, Printed]:
    """The paper's figures by key."""
    path = Path(str(resources.files("analysis.reproduce") / "paper.toml"))
    return {figure.key: figure for figure in read_toml(path, Paper).printed}


@dataclass(frozen=True, kw_only=True)
class Line:
    """A printed figure beside ours.

    Attributes:
        key, place, what, channel, unit: which figure.
        printed: the paper's; ours is compared to its printed digits.
        ours: what we find, with its standard error (0 where it is exact).
        expected: what a closed form says that we should find, where there is one.
        agrees: whether ours, rounded as printed, is within reach of the printed one.
        why: where they differ, in a sentence; else what stands behind the figure, or nothing.
    """

    key: str
    place: str
    what: str
    channel: str
    unit: str
    printed: float
    ours: float
    se: float
    expected: float | None
    agrees: bool
    why: str

    def to_json(self) -> dict[str, Any]:
        """The line as plain data."""
        return dict(vars(self))


def compare(
    key: str,
    ours: float,
    se: float,
    *,
    channel: str = "all",
    expected: float | None = None,
    why: str = "",
) -> Line:
    """A line of comparison; `why` is what to say of a disagreement.

    They agree when they differ by no more than half a printed digit and `CLEAR` standard errors.
    """
    figure = printed()[key]
    value = figure.value[channel]
    reach = 0.5 * 10.0**-figure.decimals + CLEAR * se
    agrees = abs(ours - value) <= reach * (1 + 1e-9)
    return Line(
        key=key,
        place=figure.place,
        what=figure.what,
        channel=channel,
        unit=figure.unit,
        printed=value,
        ours=ours,
        se=se,
        expected=expected,
        agrees=agrees,
        why="" if agrees else why,
    )
