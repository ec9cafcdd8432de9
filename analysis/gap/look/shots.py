"""Which shots and frames take part: some choose and fit, the others are kept for the score."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from analysis.gap.look.observation import Stack
from analysis.gap.look.repeats import fresh, partly_repeats, repeats
from sensor.frames import Capture, Frames

GROUP_FRAMES = 8
"""Frames that are looked at together. Real and simulated captures are looked at in groups of the
same size, so that whatever a finite group does to a statistic it does to both."""

LARGE_PX = 160_000
"""Of larger frames half as many make a group: there are pixels enough in them."""

MOST_GROUPS = 6
"""Groups of a shot that are looked at."""

HINT_FRAMES = 16
"""Frames of a shot by which frames tell something by themselves, before any model."""

FEWEST_FRAMES = 4
"""A shot with fewer cannot be split into two groups that both have noise in time."""

FEWEST_SHOTS = 2
"""Shots with frames enough that a diagnosis needs: one cannot tell gain from read noise."""

KEY_SHOTS = 5
"""Shots that choose and fit: enough for two lamps, two levels, and two exposures in the dark."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Who does what.

    Attributes:
        frames: frames in a group.
        groups: groups of each shot.
        key: labels of the shots that choose and fit, with every other group of theirs.
        other: labels of the shots that are not looked at: they would show the same again.
        unused: labels of the shots with too few frames.
    """

    frames: int
    groups: int
    key: tuple[str, ...]
    other: tuple[str, ...]
    unused: tuple[str, ...]


def plan(capture: Capture) -> Plan | None:
    """How to use a capture; None where fewer than two shots have enough frames.

    One shot cannot tell gain from read noise, nor light from black level.
    """
    usable = [f for f in capture.frames if f.count >= FEWEST_FRAMES]
    if len(usable) < FEWEST_SHOTS:
        return None
    typical = int(np.median([f.count for f in usable]))
    # darks may have fewer frames than the rest, and are worth more
    fewest = min(f.count for f in usable if f.count >= typical // 2)
    large = usable[0].height * usable[0].width > LARGE_PX
    frames = max(2, min(GROUP_FRAMES // (2 if large else 1), fewest // 2 // 2 * 2))
    usable = [f for f in usable if f.count >= 2 * frames]
    if len(usable) < FEWEST_SHOTS:
        return None
    groups = min(MOST_GROUPS, min(f.count for f in usable) // frames)
    key = tuple(_key_shots(usable, groups * frames))
    return Plan(
        frames=frames,
        groups=groups,
        key=key,
        other=tuple(f.shot.label for f in usable if f.shot.label not in key),
        unused=tuple(f.shot.label for f in capture.frames if f not in usable),
    )


def _key_shots(usable: list[Frames], wanted: int) -> list[str]:
    """The dark extremes, the brightest of each lamp, then levels in between and the faintest: in
    capture order. A shot that repeats frames takes the place of the last of them, where none of
    them does.

    Two levels lie on a line, whatever a camera does; of one lamp there is room for a third.

    Args:
        usable: shots with enough frames.
        wanted: frames of each that are looked at.
    """
    darks = _rungs((f for f in usable if f.shot.dark), lambda f: f.shot.exposure_s)
    chosen: list[Frames] = [*darks[-1:]]
    lamps: dict[tuple[str, ...], list[Frames]] = {}
    for f in usable:
        if not f.shot.dark:
            lamps.setdefault(f.shot.light, []).append(f)
    ladders = [_rungs(shots, _light) for shots in lamps.values()]
    chosen += [rungs[-1] for rungs in ladders]
    chosen += darks[:1] if len(darks) > 1 else []
    chosen += [rungs[len(rungs) // 3] for rungs in ladders if len(rungs) > 1]
    chosen += [rungs[0] for rungs in ladders if len(ladders) == 1]
    chosen += darks[1:-1] + [f for rungs in ladders for f in rungs]
    distinct = list(dict.fromkeys(f.shot.label for f in chosen))[:KEY_SHOTS]
    # a cable drops frames of any shot, and few of them; all that are white are alike
    dropped = {f.shot.label: int(repeats(f.dn[:wanted]).sum()) for f in usable if not _white(f)}
    most = max(dropped, key=lambda label: dropped[label], default="")
    if dropped.get(most) and not any(dropped[label] for label in distinct):
        distinct[-1] = most
    return [f.shot.label for f in usable if f.shot.label in distinct]


def _rungs(shots: Iterable[Frames], bright: Callable[[Frames], float]) -> list[Frames]:
    """The faintest first; none that is white, unless all are."""
    rungs = sorted(shots, key=bright)
    return [f for f in rungs if not _white(f)] or rungs[:1]


def _light(frames: Frames) -> float:
    return frames.shot.exposure_s * sum(frames.shot.level)


def _white(frames: Frames) -> bool:
    """Whether more than a tenth of a frame is at the top."""
    return float((frames.dn[0] >= frames.top_dn).mean()) > 0.1


def stack_of(frames: Frames, plan: Plan) -> Stack:
    """A shot in groups of frames."""
    wanted = plan.groups * plan.frames
    taken = np.asarray(frames.dn[:wanted])
    return Stack(
        label=frames.shot.label,
        lit=not frames.shot.dark,
        groups=np.split(fresh(taken, wanted), plan.groups),
        counted=len(taken),
        repeated=int(repeats(taken).sum()),
        in_part=int(partly_repeats(taken).sum()),
    )
