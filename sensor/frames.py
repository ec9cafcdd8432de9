"""Frames and captures, real or simulated: all that an estimator may see of a camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from foundation.panel import Panel
from sensor.errors import CaptureError, TooFewFrames
from sensor.protocol import Shot

__all__ = [
    "MOSAICS",
    "MOSAIC_WORDS",
    "PIXELS",
    "Capture",
    "CaptureError",
    "Frames",
    "Panel",
    "Pixels",
    "Shot",
    "TooFewFrames",
    "central_panel",
]

Pixels = Literal["rgb8", "bayer8", "bayer16", "mono8", "mono16"]
PIXELS: Mapping[Pixels, tuple[int, type[np.generic]]] = {
    "rgb8": (4, np.uint8),
    "bayer8": (3, np.uint8),
    "bayer16": (3, np.uint16),
    "mono8": (3, np.uint8),
    "mono16": (3, np.uint16),
}
"""Dimensions of a stack and type of a sample, by kind of pixel."""

MOSAICS = ("RGGB", "BGGR", "GRBG", "GBRG")
MOSAIC_WORDS = f"{', '.join(MOSAICS)}: one R, one B, and G twice on a diagonal"
"""The colours that a Bayer mosaic can have at (0,0) (0,1) (1,0) (1,1)."""

PANEL_PX = 50
"""Width and height of an analysis area in the paper, and of the default one."""


def central_panel(height: int, width: int) -> Panel:
    """The central 50 x 50 pixels, or all there is of a smaller image."""
    w, h = min(width, PANEL_PX), min(height, PANEL_PX)
    return Panel(name="centre", x=(width - w) // 2, y=(height - h) // 2, w=w, h=h)


@dataclass(frozen=True, kw_only=True, eq=False)
class Frames:
    """A stack of frames of one shot.

    Attributes:
        dn: pixel values in DN, right-justified: (N, H, W, 3) for rgb8, else (N, H, W). May be
            memory-mapped; nothing here reads more of it than it is asked for.
        shot: how they were taken.
        pixels: the kind of pixel.
        bits: significant bits of a pixel.
        cfa: colours of the pixels (0,0) (0,1) (1,0) (1,1), as in ``"RGGB"``, where known.
    """

    dn: NDArray[Any]
    shot: Shot
    pixels: Pixels
    bits: int
    cfa: str | None = None

    def __post_init__(self) -> None:
        dimensions, kind = PIXELS[self.pixels]
        if self.dn.ndim != dimensions or (dimensions == 4 and self.dn.shape[-1] != 3):
            raise CaptureError(
                f"the frames of shot '{self.shot.label}' have shape {self.dn.shape}",
                f"expected {'(N, H, W, 3)' if dimensions == 4 else '(N, H, W)'} for {self.pixels}",
                "correct 'pixels' or the file",
            )
        if self.dn.dtype != kind:
            raise CaptureError(
                f"the frames of shot '{self.shot.label}' hold {self.dn.dtype}",
                f"expected {np.dtype(kind)} for {self.pixels}",
                "correct 'pixels' or the file",
            )

    @property
    def count(self) -> int:
        """Number of frames."""
        return int(self.dn.shape[0])

    @property
    def height(self) -> int:
        """Rows of a frame."""
        return int(self.dn.shape[1])

    @property
    def width(self) -> int:
        """Columns of a frame."""
        return int(self.dn.shape[2])

    @property
    def top_dn(self) -> int:
        """The largest pixel value that the bits allow."""
        return int(2**self.bits - 1)

    @property
    def demosaiced(self) -> bool:
        """Whether every pixel has all three colours."""
        return self.pixels == "rgb8"

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels: R G B, or Y for a camera without colours."""
        return ("Y",) if self.pixels.startswith("mono") else ("R", "G", "B")

    def lattices(self, panel: Panel, channel: str) -> tuple[NDArray[Any], ...]:
        """The samples of one channel in a panel, each a stack (N, h, w) on a regular lattice.

        A colour image has one lattice per channel, a Bayer mosaic two for G: its two sites have
        different neighbours, so they are never mixed. Only the panel is read from memory.
        """
        rows, columns = panel.window
        if self.demosaiced:
            return (self.dn[:, rows, columns, "RGB".index(channel)],)
        if channel == "Y":
            return (self.dn[:, rows, columns],)
        stack = self.dn[:, rows, columns]
        assert self.cfa is not None
        phases = [(k // 2, k % 2) for k in range(4) if self.cfa[k] == channel]
        return tuple(stack[:, (i - panel.y) % 2 :: 2, (j - panel.x) % 2 :: 2] for i, j in phases)


@dataclass(frozen=True, kw_only=True, eq=False)
class Capture:
    """What one camera recorded: frames of several shots, and where to look in them.

    Attributes:
        camera: free text, or the name of a preset.
        frames: one stack per shot; at least one, all of one size and kind.
        panels: areas to analyse; empty where nobody said.
        scene: name or path of the scene, where known; no estimator reads it.
    """

    camera: str
    frames: tuple[Frames, ...]
    panels: tuple[Panel, ...] = ()
    scene: str | None = None

    def __post_init__(self) -> None:
        if not self.frames:
            raise CaptureError("a capture without shots", "expected at least one", "add a [[shot]]")
        first = self.frames[0]
        if not first.pixels.startswith("mono") and not first.demosaiced and first.cfa is None:
            raise CaptureError(
                f"{first.pixels} frames without 'cfa'", "expected their colours", 'add cfa = "RGGB"'
            )
        for other in self.frames[1:]:
            if (other.height, other.width) != (first.height, first.width):
                raise CaptureError(
                    f"shot '{other.shot.label}' has {other.width} x {other.height} pixels",
                    f"expected {first.width} x {first.height} as in shot '{first.shot.label}'",
                    "put frames of one size in one capture",
                )
        names = [panel.name for panel in self.panels]
        for panel in self.panels:
            if names.count(panel.name) > 1:
                raise CaptureError(
                    f"two panels are called '{panel.name}'",
                    "expected every name once",
                    "rename one",
                )
            if panel.x + panel.w > first.width or panel.y + panel.h > first.height:
                raise CaptureError(
                    f"panel '{panel.name}' reaches to x = {panel.x + panel.w},"
                    f" y = {panel.y + panel.h}",
                    f"expected it inside {first.width} x {first.height} pixels",
                    "correct its x, y, w or h",
                )

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels of every frame."""
        return self.frames[0].channels

    @property
    def darks(self) -> tuple[Frames, ...]:
        """The stacks taken without light."""
        return tuple(f for f in self.frames if f.shot.dark)

    @property
    def lit(self) -> tuple[Frames, ...]:
        """The stacks taken with light."""
        return tuple(f for f in self.frames if not f.shot.dark)

    @property
    def areas(self) -> tuple[Panel, ...]:
        """The panels, or the central one where there are none."""
        first = self.frames[0]
        return self.panels or (central_panel(first.height, first.width),)
