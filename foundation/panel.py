"""A named rectangle of pixels: the one word that scene, render, frames and analysis share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from foundation.documents import STRICT


@dataclass(frozen=True, kw_only=True)
class Panel:
    """An area to analyse: its name, top left corner and size in pixels."""

    name: str
    x: Annotated[int, Field(ge=0)]
    y: Annotated[int, Field(ge=0)]
    w: Annotated[int, Field(ge=1)]
    h: Annotated[int, Field(ge=1)]

    __pydantic_config__ = STRICT

    @property
    def window(self) -> tuple[slice, slice]:
        """The rows and columns of the panel."""
        return slice(self.y, self.y + self.h), slice(self.x, self.x + self.w)
