"""A figure that differs by colour filter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from foundation.documents import STRICT

CHANNELS = ("R", "G", "B")


@dataclass(frozen=True, kw_only=True)
class Colours:
    """One figure for each of red, green and blue, in the unit of its name's suffix."""

    R: Annotated[float, Field()]
    G: Annotated[float, Field()]
    B: Annotated[float, Field()]

    __pydantic_config__ = STRICT

    @classmethod
    def of(cls, figure: float | Colours) -> Colours:
        """A float stands for three equal figures."""
        return figure if isinstance(figure, Colours) else cls(R=figure, G=figure, B=figure)

    def __getitem__(self, channel: str) -> float:
        return float(getattr(self, channel))

    def __iter__(self) -> Any:
        return iter((self.R, self.G, self.B))

    @property
    def uniform(self) -> bool:
        """Whether all three are equal."""
        return self.R == self.G == self.B

    def map(self, function: Callable[..., float], other: float | Colours | None = None) -> Colours:
        """Apply a function colour by colour, to one figure or to two."""
        if other is None:
            return Colours(**{c: function(self[c]) for c in CHANNELS})
        second = Colours.of(other)
        return Colours(**{c: function(self[c], second[c]) for c in CHANNELS})

    def plain(self) -> float | dict[str, float]:
        """A float where all are equal, else a table by channel: as documents spell it."""
        return self.R if self.uniform else {c: self[c] for c in CHANNELS}


def _three(value: Any) -> Any:
    return dict.fromkeys(CHANNELS, value) if isinstance(value, (int, float)) else value


PerColour = Annotated[Colours, BeforeValidator(_three)]
"""A document's figure that may be one number or a table of three."""
