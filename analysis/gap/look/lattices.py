"""A capture as stacks of measured samples: the four sites of a mosaic, or the one of a grey camera.

A demosaiced image still holds the mosaic: bilinear and most other interpolations leave the samples
that were measured as they are. Looking at those alone makes the noise of a colour image as white as
that of a raw one; what the interpolated samples add is looked at by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensor.frames import Capture

Array = NDArray[np.float32]

SITES = ((0, 0), (0, 1), (1, 0), (1, 1))
"""Rows and columns of the four sites of a mosaic's square."""

BORDER_PX = 8
"""Pixels along the border that are not looked at; a multiple of 8, to keep the phase
of a mosaic and of the blocks of a codec."""


def inner(stack: NDArray[Any]) -> NDArray[Any]:
    """Frames (N, H, W, ...) without their border."""
    return stack[:, BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX]


@dataclass(frozen=True, kw_only=True)
class Lattice:
    """A regular lattice of samples of one colour.

    Attributes:
        name: "R", "G1", "G2", "B", or "Y"; unique within a camera.
        channel: the channel it belongs to.
        dy, dx: its first sample in the frame.
        step: distance of samples in pixels.
    """

    name: str
    channel: str
    dy: int
    dx: int
    step: int

    def of(self, dn: NDArray[Any]) -> NDArray[Any]:
        """Its samples in a stack of frames, (N, h, w), away from the border.

        What a camera puts beyond the last pixel when it interpolates is nobody's business here.
        All lattices of a camera have as many samples: a last row or column of its own is left out.
        """
        plane = inner(dn[..., "RGB".index(self.channel)] if dn.ndim == 4 else dn)
        h, w = (n // self.step * self.step for n in plane.shape[1:])
        return plane[:, self.dy : h : self.step, self.dx : w : self.step]


def of_a_mosaic(lattices: Sequence[Lattice]) -> bool:
    """Whether each pixel is known to have measured one colour: four sites, not one of grey or three
    whole channels.
    """
    return len(lattices) == len(SITES)


def channels_of(lattices: Sequence[Lattice]) -> tuple[str, ...]:
    """The colours of lattices, red first whatever the mosaic begins with; "Y" of a grey camera."""
    return tuple(sorted({lattice.channel for lattice in lattices}, key="RGBY".index))


def lattices_of(capture: Capture) -> tuple[Lattice, ...]:
    """The lattices of a capture, in the order of their sites.

    A colour image whose mosaic nobody stated is looked for it: see `phase_of`. Where none can be
    told, each channel is one lattice of all pixels.
    """
    first = capture.frames[0]
    if capture.channels == ("Y",):
        return (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)
    cfa = first.cfa or phase_of(capture)
    if cfa is None:
        return tuple(Lattice(name=c, channel=c, dy=0, dx=0, step=1) for c in "RGB")
    seen: dict[str, int] = {}
    made = []
    for (dy, dx), channel in zip(SITES, cfa, strict=True):
        seen[channel] = seen.get(channel, 0) + 1
        name = f"{channel}{seen[channel]}" if cfa.count(channel) > 1 else channel
        made.append(Lattice(name=name, channel=channel, dy=dy, dx=dx, step=2))
    return tuple(made)


def phase_of(capture: Capture) -> str | None:
    """The mosaic behind colour images, told by where red and blue are noisiest in time.

    An interpolated sample is a mean and has less noise: a quarter to a half of the variance. The
    answer is None unless one site of red and one of blue stand out and are diagonal to each other.
    """
    best: dict[str, int] = {}
    for colour in (0, 2):
        variances = np.zeros(4)
        for frames in capture.frames:
            if frames.count < 2:
                continue
            pair = frames.dn[:8, ..., colour].astype(np.float32)
            noise = pair.var(axis=0, ddof=1)
            variances += [float(noise[dy::2, dx::2].mean()) for dy, dx in SITES]
        order = np.argsort(variances)
        if variances[order[2]] > 0.8 * variances[order[3]]:
            return None
        best["RGB"[colour]] = int(order[3])
    if best["R"] + best["B"] != 3:
        return None
    return "".join("R" if k == best["R"] else "B" if k == best["B"] else "G" for k in range(4))
