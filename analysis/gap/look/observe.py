"""Every statistic of a capture, group of frames by group, and its mean images block by block."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.lattices import Lattice, channels_of, inner
from analysis.gap.look.statistics.codes import codes
from analysis.gap.look.statistics.greens import greens
from analysis.gap.look.statistics.group import Figures, Group
from analysis.gap.look.statistics.interpolation import interpolation
from analysis.gap.look.statistics.pattern import pattern, pattern_lines, pattern_shape
from analysis.gap.look.statistics.spectrum import spectrum
from analysis.gap.look.statistics.structure import columns, frames, neighbours, rows, tails, time
from analysis.gap.look.statistics.surface import surface
from analysis.gap.look.statistics.transfer import level, transfer
from foundation.cores import cores, products_on_one_core

Floats = NDArray[np.float64]

FAMILIES: dict[str, tuple[Callable[[Group], Figures], str]] = {
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
GREENS = "greens"
IMAGE = "mean image"
STAGES = {name: stage for name, (_, stage) in FAMILIES.items()} | {
    INTERPOLATION: "processing",
    GREENS: "photosite",
    IMAGE: "optics",
}

OF_A_BODY = frozenset(
    {
        "level",
        "codes",
        "pattern",
        "pattern lines",
        "pattern shape",
        "dark surface",
        "texture",
        GREENS,
    }
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


@products_on_one_core()
def observe(stacks: Iterable[Stack], view: View) -> Observation:
    """Look at a capture, on every core.

    Args:
        stacks: the groups of frames of each shot; as many groups for each.
        view: how to look.
    """
    names: dict[str, list[_Name]] = {}
    looks: dict[_Name, _Seen] = {}
    waiting: dict[bool, dict[_Name, NDArray[Any]]] = {False: {}, True: {}}
    repeated, lit = [], set()
    for stack in stacks:
        repeated.append(stack.repeated)
        if stack.lit:
            lit.add(stack.label)
        groups = [np.ascontiguousarray(dn) for dn in stack.groups]
        names[stack.label] = [_Name.of(dn, stack.lit, view) for dn in groups]
        alike = waiting[stack.lit]
        for name, dn in zip(names[stack.label], groups, strict=True):
            if name in _kept:
                looks[name] = _kept[name]
                continue
            alike[name] = dn
            if sum(one.size for one in alike.values()) >= TOGETHER:
                looks |= _begun(alike, stack.lit, view)
                alike.clear()
    for kind, alike in waiting.items():
        looks |= _begun(alike, kind, view)
    _keep(looks)
    seen = [(label, [looks[name] for name in shot]) for label, shot in names.items()]
    keys: list[Key] = []
    by_key: list[Sequence[float]] = []
    for label, shot in seen:
        shared = tuple(w for w in shot[0].figures if all(w in one.figures for one in shot[1:]))
        keys += _keys(label, shared)
        by_key += zip(*([one.figures[where] for where in shared] for one in shot), strict=True)
    # they are so few that only all shots together tell how many
    keys.append(Key(shot=EVERY_SHOT, lattice="all", family="time", statistic=REPEATED))
    by_key.append([float(np.mean(repeated))] * len(seen[0][1]))
    channels = channels_of(view.lattices)
    return Observation(
        keys=tuple(keys),
        figures=np.array(by_key).T,
        shots=tuple(label for label, _ in seen),
        lit=frozenset(lit),
        channels=channels,
        means=np.array([[one.lattices.means for one in shot] for _, shot in seen]).swapaxes(0, 1),
        noise=np.array([np.mean([one.lattices.noise for one in shot], axis=0) for _, shot in seen]),
        grid=seen[0][1][0].lattices.grid,
        samples=view.side**2 * (len(view.lattices) // len(channels)),
        frames=view.frames,
    )


@functools.lru_cache(maxsize=128)
def _keys(shot: str, figures: tuple[tuple[str, str, str], ...]) -> tuple[Key, ...]:
    """Names of what was seen of a shot, of every twin the same objects."""
    return tuple(Key(shot=shot, lattice=la, family=fa, statistic=st) for fa, la, st in figures)


@dataclass(frozen=True)
class _Name:
    """What makes two groups of frames the same, and seen in the same way."""

    checks: tuple[tuple[int, bytes], ...]
    kind: tuple[tuple[int, ...], np.dtype[Any]]
    lit: bool
    view: View

    @staticmethod
    def of(dn: NDArray[Any], lit: bool, view: View) -> _Name:
        # of each frame: cameras that differ do so in all of them
        checks = tuple(_check(frame.ravel().view(np.uint8)) for frame in dn)
        return _Name(checks, (dn.shape, dn.dtype), lit, view)


def _check(content: NDArray[np.uint8]) -> tuple[int, bytes]:
    """A check value: words of eight bytes times odd numbers, modulo 2^64, and the bytes left over.

    No single word can change it unseen; several do with a chance of 2^-64.
    """
    whole = content.size // 8
    words = content[: 8 * whole].view(np.uint64)
    return int(words @ _odd_numbers(whole)), content[8 * whole :].tobytes()


@functools.lru_cache(maxsize=4)
def _odd_numbers(count: int) -> NDArray[np.uint64]:
    return np.random.default_rng(0).integers(2**63, size=count, dtype=np.uint64) * 2 + 1


@dataclass(frozen=True, kw_only=True, eq=False)
class _Lattices:
    """Figures of one group by family, lattice and statistic; mean images and noise of channels."""

    figures: dict[tuple[str, str, str], float]
    means: Floats
    noise: Floats
    grid: tuple[int, int]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Seen:
    """What was seen of one group of frames, as soon as it is asked for."""

    batch: Future[list[_Lattices]]
    place: int
    between: Future[dict[tuple[str, str, str], float]]

    @property
    def lattices(self) -> _Lattices:
        return self.batch.result()[self.place]

    @cached_property
    def figures(self) -> dict[tuple[str, str, str], float]:
        return self.lattices.figures | self.between.result()


TOGETHER = 1_000_000
"""Pixel values from which groups are no longer looked at together: about what a core's cache holds.
Below, what is in a call counts for less than the call.
"""

KEPT = 256
"""Groups of frames of which it is kept what was seen: many changes of a camera leave darks as they
are, with the same random numbers to the last bit.
"""

_kept: dict[_Name, _Seen] = {}


def _keep(looks: Mapping[_Name, _Seen]) -> None:
    for name, seen in looks.items():
        _kept.pop(name, None)
        _kept[name] = seen  # the last that was asked for is the last to go
    while len(_kept) > KEPT:
        _kept.pop(next(iter(_kept)))


def _begun(groups: Mapping[_Name, NDArray[Any]], lit: bool, view: View) -> dict[_Name, _Seen]:
    """Groups of shots that are all in the dark or all lit, begun to be looked at together."""
    if not groups:
        return {}
    batch = _cores().submit(_on_lattices, list(groups.values()), lit, view)
    return {
        name: _Seen(batch=batch, place=k, between=_cores().submit(_between, dn, view))
        for k, (name, dn) in enumerate(groups.items())
    }


def _on_lattices(groups: Sequence[NDArray[Any]], lit: bool, view: View) -> list[_Lattices]:
    """Every family on every lattice; images of lattices of one channel are averaged."""
    lattices, channels = view.lattices, [lattice.channel for lattice in view.lattices]
    codes = np.array([lattice.of(dn) for dn in groups for lattice in lattices])
    group = Group(codes=codes, top_dn=view.top_dn, lit=lit)
    names, columns = [], []
    for family, (function, _) in FAMILIES.items():
        for statistic, values in function(group).items():
            names.append((family, statistic))
            columns.append(values)
    figures = np.array(columns).T.reshape(len(groups), len(lattices), -1).tolist()
    images = blocks(group.mean, view.side)
    grid = images.shape[1], images.shape[2]
    images = images.reshape(len(groups), len(lattices), -1)
    variance = group.variance.reshape(len(groups), len(lattices))
    places = [np.array(channels) == one for one in channels_of(lattices)]
    return [
        _Lattices(
            figures={
                (family, lattice.name, statistic): value
                for lattice, values in zip(lattices, figures[k], strict=True)
                for (family, statistic), value in zip(names, values, strict=True)
            }
            | _whole(GREENS, greens(images[k], lattices) if lit else {}),
            means=np.array([images[k, own].mean(axis=0) for own in places]),
            noise=np.array([variance[k, own].mean() for own in places]),
            grid=grid,
        )
        for k in range(len(groups))
    ]


def _between(dn: NDArray[Any], view: View) -> dict[tuple[str, str, str], float]:
    return _whole(INTERPOLATION, interpolation(inner(dn), view.lattices))


def _whole(family: str, found: Figures) -> dict[tuple[str, str, str], float]:
    """Figures that belong to no lattice by itself."""
    return {(family, "all", name): float(value) for name, value in found.items()}


def blocks(image: NDArray[Any], side: int) -> Floats:
    """Means over square blocks; what does not fill one is left out."""
    h, w = (n // side * side for n in image.shape[-2:])
    cut = image[..., :h, :w].astype(np.float64)
    return np.asarray(
        cut.reshape(*image.shape[:-2], h // side, side, w // side, side).mean(axis=(-3, -1))
    )
