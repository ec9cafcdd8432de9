"""What is looked at, how, and what was seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice

Floats = NDArray[np.float64]

BLOCKS_DOWN = 16
"""Blocks of the mean image from top to bottom."""


@dataclass(frozen=True, kw_only=True, order=True)
class Key:
    """What a figure is of."""

    shot: str
    lattice: str
    family: str
    statistic: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Observation:
    """What was seen in one capture.

    Attributes:
        keys: of the figures.
        figures: one row per group of frames, (g, keys).
        shots, channels: labels of the axes of the mean images.
        lit: labels of the shots with a lamp on.
        means: block means in DN, (g, shots, channels, blocks).
        noise: variance in time of one sample in DN^2, (shots, channels).
        grid: blocks down and across.
        samples: samples of a channel in a block.
        frames: frames in a group.
        counted: frames as they came, of all shots, among which repeats were counted; halves of a
            capture share this count.
    """

    keys: tuple[Key, ...]
    figures: Floats
    shots: tuple[str, ...]
    lit: frozenset[str]
    channels: tuple[str, ...]
    means: Floats
    noise: Floats
    grid: tuple[int, int]
    samples: int
    frames: int
    counted: int

    @property
    def groups(self) -> int:
        """Number of groups of frames."""
        return len(self.figures)


@dataclass(frozen=True, kw_only=True)
class View:
    """How a capture is looked at: the same for a real one and for its simulated twins.

    Attributes:
        lattices: where its measured samples are.
        frames: frames in a group.
        side: samples of a lattice along the side of a block.
        top_dn: the largest pixel value.
    """

    lattices: tuple[Lattice, ...]
    frames: int
    side: int
    top_dn: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Stack:
    """The frames of a shot, ready to be looked at.

    Attributes:
        label: of the shot.
        lit: whether a lamp was on.
        groups: its frames in groups, none of which repeats another.
        counted: frames as they came.
        repeated: how many of these repeated the one before.
        in_part: how many others repeated rows of the one before.
    """

    label: str
    lit: bool
    groups: Sequence[NDArray[Any]]
    counted: int
    repeated: int
    in_part: int = 0
