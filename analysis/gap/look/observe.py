"""Every statistic of a capture, group of frames by group, and its mean images block by block."""

from __future__ import annotations

import functools
import zlib
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice, inner
from analysis.gap.look.statistics.codes import codes
from analysis.gap.look.statistics.group import Group
from analysis.gap.look.statistics.interpolation import interpolation
from analysis.gap.look.statistics.pattern import pattern, pattern_lines, pattern_shape
from analysis.gap.look.statistics.spectrum import spectrum
from analysis.gap.look.statistics.structure import columns, frames, neighbours, rows, tails, time
from analysis.gap.look.statistics.surface import surface
from analysis.gap.look.statistics.transfer import level, transfer
from foundation.cores import cores

Floats = NDArray[np.float64]

FAMILIES: dict[str, tuple[Callable[[Group], dict[str, float]], str]] = {
    "level": (level, "readout"),
    "transfer": (transfer, "photosite"),
    "rows": (rows, "readout"),
    "columns": (columns, "readout"),
    "frames": (frames, "lighting"),
    "neighbours": (neighbours, "processing"),
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
IMAGE = "mean image"
STAGES = {name: stage for name, (_, stage) in FAMILIES.items()} | {
    INTERPOLATION: "processing",
    IMAGE: "optics",
}

OF_A_BODY = frozenset(
    {"level", "codes", "pattern", "pattern lines", "pattern shape", "dark surface", "texture"}
)
"""Families of what stays from frame to frame: more frames do not average a camera body away."""

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
        repeated: part of the frames as they came that repeated the one before.
    """

    label: str
    lit: bool
    groups: Sequence[NDArray[Any]]
    repeated: float


EVERY_SHOT = "every shot"
REPEATED = "repeated frames"


@functools.cache
def _cores() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(cores())


def observe(stacks: Iterable[Stack], view: View) -> Observation:
    """Look at a capture, on every core.

    Args:
        stacks: the groups of frames of each shot; as many groups for each.
        view: how to look.
    """
    jobs: list[tuple[str, list[list[Future[_Seen]]]]] = []
    repeated, lit = [], set()
    for stack in stacks:
        repeated.append(stack.repeated)
        if stack.lit:
            lit.add(stack.label)
        jobs.append((stack.label, [_looked_at(dn, stack.lit, view) for dn in stack.groups]))
    seen = [
        (label, [_joined(view, [part.result() for part in parts]) for parts in groups])
        for label, groups in jobs
    ]
    keys: list[Key] = []
    by_key: list[Sequence[float]] = []
    for label, shot in seen:
        shared = tuple(w for w in shot[0].figures if all(w in one.figures for one in shot[1:]))
        keys += _keys(label, shared)
        by_key += zip(*([one.figures[where] for where in shared] for one in shot), strict=True)
    # they are so few that only all shots together tell how many
    keys.append(Key(shot=EVERY_SHOT, lattice="all", family="time", statistic=REPEATED))
    by_key.append([float(np.mean(repeated))] * len(seen[0][1]))
    channels = tuple(dict.fromkeys(lattice.channel for lattice in view.lattices))
    first = seen[0][1][0]
    return Observation(
        keys=tuple(keys),
        figures=np.array(by_key).T,
        shots=tuple(label for label, _ in seen),
        lit=frozenset(lit),
        channels=channels,
        means=np.array([[one.means for one in shot] for _, shot in seen]).swapaxes(0, 1),
        noise=np.array([np.mean([one.noise for one in shot], axis=0) for _, shot in seen]),
        grid=first.grid,
        samples=view.side**2 * (len(view.lattices) // len(channels)),
        frames=view.frames,
    )


@functools.lru_cache(maxsize=128)
def _keys(shot: str, figures: tuple[tuple[str, str, str], ...]) -> tuple[Key, ...]:
    """Names of what was seen of a shot, of every twin the same objects."""
    return tuple(Key(shot=shot, lattice=la, family=fa, statistic=st) for fa, la, st in figures)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Seen:
    """Figures of one group by family, lattice and statistic; mean images and noise of channels."""

    figures: dict[tuple[str, str, str], float]
    means: Floats
    noise: Floats
    grid: tuple[int, int]


KEPT = 256
"""Groups of frames of which it is kept what was seen: many changes of a camera leave darks as they
are, with the same random numbers to the last bit.
"""

_kept: dict[tuple[object, ...], list[Future[_Seen]]] = {}


def _looked_at(dn: NDArray[Any], lit: bool, view: View) -> list[Future[_Seen]]:
    """One group of frames, lattice by lattice, and what all lattices have together."""
    group = np.ascontiguousarray(dn)
    # a check value of each frame: cameras that differ do so in all of them
    checks = tuple(zlib.crc32(frame.data) for frame in group)
    name = (checks, dn.shape, dn.dtype, lit, view)
    seen = _kept.pop(name, None)
    if seen is None:
        alone = [_cores().submit(_lattice, group, lit, view, one) for one in view.lattices]
        seen = [*alone, _cores().submit(_all_lattices, group, lit, view)]
    _kept[name] = seen  # the last that was asked for is the last to go
    if len(_kept) > KEPT:
        _kept.pop(next(iter(_kept)), None)
    return seen


def _lattice(dn: NDArray[Any], lit: bool, view: View, lattice: Lattice) -> _Seen:
    codes = np.ascontiguousarray(lattice.of(dn))
    group = Group(codes=codes, top_dn=view.top_dn, lit=lit)
    image = blocks(group.mean, view.side)
    return _Seen(
        figures={
            (family, lattice.name, name): value
            for family, (function, _) in FAMILIES.items()
            for name, value in function(group).items()
        },
        means=image.ravel()[None],
        noise=np.array([group.variance]),
        grid=(image.shape[0], image.shape[1]),
    )


def _all_lattices(dn: NDArray[Any], lit: bool, view: View) -> _Seen:
    found = interpolation(inner(dn), view.lattices, lit)
    figures = {(INTERPOLATION, "all", name): value for name, value in found.items()}
    return _Seen(figures=figures, means=np.empty((0, 0)), noise=np.empty(0), grid=(0, 0))


def _joined(view: View, parts: Sequence[_Seen]) -> _Seen:
    """All of a group; lattices of one channel are averaged."""
    channels = [lattice.channel for lattice in view.lattices]
    places = [
        [k for k, channel in enumerate(channels) if channel == one]
        for one in dict.fromkeys(channels)
    ]
    return _Seen(
        figures={key: value for part in parts for key, value in part.figures.items()},
        means=np.array([np.mean([parts[k].means[0] for k in own], axis=0) for own in places]),
        noise=np.array([np.mean([parts[k].noise[0] for k in own]) for own in places]),
        grid=parts[0].grid,
    )


def blocks(image: NDArray[Any], side: int) -> Floats:
    """Means over square blocks; what does not fill one is left out."""
    h, w = (n // side * side for n in image.shape[-2:])
    cut = image[..., :h, :w].astype(np.float64)
    return np.asarray(
        cut.reshape(*image.shape[:-2], h // side, side, w // side, side).mean(axis=(-3, -1))
    )
