"""Every statistic of a capture, group of frames by group; what was seen once is kept."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.look.families import EVERY_SHOT, REPEATED, REPEATED_IN_PART
from analysis.gap.look.lattices import channels_of
from analysis.gap.look.observation import Key, Observation, Stack, View
from analysis.gap.look.one_group import OfAGroup, between, on_lattices
from foundation.cores import cores, products_on_one_core

Floats = NDArray[np.float64]


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
    return begun(stacks, view)()


def begun(stacks: Iterable[Stack], view: View) -> Callable[[], Observation]:
    """Begin to look at a capture, on every core; see `foundation.cores.ahead`.

    Args:
        stacks: the groups of frames of each shot; as many groups for each.
        view: how to look.

    Returns:
        a function that waits until all is looked at, and returns the observation.
    """
    names: dict[str, list[_Name]] = {}
    looks: dict[_Name, _Seen] = {}
    waiting: dict[bool, dict[_Name, NDArray[Any]]] = {False: {}, True: {}}
    counted, repeated, in_part, lit = 0, 0, 0, set()
    for stack in stacks:
        counted += stack.counted
        repeated += stack.repeated
        in_part += stack.in_part
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
                looks |= _submitted(alike, stack.lit, view)
                alike.clear()
    for kind, alike in waiting.items():
        looks |= _submitted(alike, kind, view)
    _keep(looks)
    seen = [(label, [looks[name] for name in shot]) for label, shot in names.items()]
    shares = {REPEATED: repeated / counted, REPEATED_IN_PART: in_part / counted}
    return functools.partial(_gathered, seen, counted, shares, frozenset(lit), view)


def _gathered(
    seen: Sequence[tuple[str, Sequence[_Seen]]],
    counted: int,
    shares: Mapping[str, float],
    lit: frozenset[str],
    view: View,
) -> Observation:
    """Everything that was seen of the groups of each shot, by its label, and which shares of the
    frames counted repeat.
    """
    keys: list[Key] = []
    by_key: list[Sequence[float]] = []
    for label, shot in seen:
        shared = tuple(w for w in shot[0].figures if all(w in one.figures for one in shot[1:]))
        keys += _keys(label, shared)
        by_key += zip(*([one.figures[where] for where in shared] for one in shot), strict=True)
    # they are so few that only all shots together tell how many
    for statistic, share in shares.items():
        keys.append(Key(shot=EVERY_SHOT, lattice="all", family="time", statistic=statistic))
        by_key.append([share] * len(seen[0][1]))
    channels = channels_of(view.lattices)
    return Observation(
        keys=tuple(keys),
        figures=np.array(by_key).T,
        shots=tuple(label for label, _ in seen),
        lit=lit,
        channels=channels,
        means=np.array([[one.lattices.means for one in shot] for _, shot in seen]).swapaxes(0, 1),
        noise=np.array([np.mean([one.lattices.noise for one in shot], axis=0) for _, shot in seen]),
        grid=seen[0][1][0].lattices.grid,
        samples=view.side**2 * (len(view.lattices) // len(channels)),
        frames=view.frames,
        counted=counted,
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
class _Seen:
    """What was seen of one group of frames, as soon as it is asked for."""

    batch: Future[list[OfAGroup]]
    place: int
    between: Future[dict[tuple[str, str, str], float]]

    @property
    def lattices(self) -> OfAGroup:
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


def _submitted(groups: Mapping[_Name, NDArray[Any]], lit: bool, view: View) -> dict[_Name, _Seen]:
    """Groups of shots that are all in the dark or all lit, begun to be looked at together."""
    if not groups:
        return {}
    batch = _cores().submit(on_lattices, list(groups.values()), lit, view)
    return {
        name: _Seen(batch=batch, place=k, between=_cores().submit(between, dn, view))
        for k, (name, dn) in enumerate(groups.items())
    }
