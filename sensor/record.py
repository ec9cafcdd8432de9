"""Taking pictures: a protocol through a camera, in memory or chunk by chunk into a stack."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from foundation.backend import Backend, backend
from foundation.panel import Panel
from sensor.camera import Camera
from sensor.frames import PIXELS, Capture, Frames
from sensor.protocol import Protocol, Shot
from sensor.signal import Signal
from sensor.simulation import await_bytes, begin, exposed, lit, pixels_of, still

BATCH_PIXELS = 32 * 640 * 480
"""Pixels simulated at once: 32 frames of the paper's size. Memory is some 400 MB then; fewer cost
time for the frames that run in, and more fit in no cache."""

Progress = Callable[[int], None]
"""Called with the number of frames that were just finished."""


def batches(camera: Camera, shot: Shot) -> Iterator[range]:
    """The frames of a shot in runs that fit in memory whatever their number."""
    size = max(1, BATCH_PIXELS // (camera.height * camera.width))
    for first in range(0, shot.frames, size):
        yield range(first, min(first + size, shot.frames))


def take(
    camera: Camera,
    shot: Shot,
    rates: Mapping[str, NDArray[np.float32]],
    *,
    seed: int = 0,
    where: Backend | None = None,
) -> Iterator[NDArray[np.generic]]:
    """The frames of one shot, batch by batch: arrays (n, H, W, 3) or (n, H, W)."""
    where = where or backend()
    light, done = lit(camera, shot, rates, where), 0
    runs = list(batches(camera, shot))
    if len(runs) > 1 and where.jit:
        light, done = still(camera, light, seed=seed)
    before: Signal | None = None
    for frames in runs:
        signal = exposed(camera, light, frames, seed=seed, done=done)
        if before is not None:
            await_bytes(before)
        begin(signal)
        if before is not None:
            yield pixels_of(camera, before)
        before = signal
    if before is not None:
        yield pixels_of(camera, before)


def stack_shape(camera: Camera, shot: Shot) -> tuple[int, ...]:
    """Shape of all frames of a shot together."""
    plane = (shot.frames, camera.height, camera.width)
    return (*plane, 3) if PIXELS[camera.pixels][0] == 4 else plane


def record(
    camera: Camera,
    protocol: Protocol,
    rates: Mapping[str, NDArray[np.float32]],
    *,
    seed: int = 0,
    panels: Sequence[Panel] = (),
    where: Backend | None = None,
    progress: Progress = lambda frames: None,
) -> Capture:
    """Take every shot of a protocol and keep the frames in memory."""
    stacks = []
    for shot in protocol.shot:
        dn = np.empty(stack_shape(camera, shot), dtype=PIXELS[camera.pixels][1])
        filled = 0
        for batch in take(camera, shot, rates, seed=seed, where=where):
            dn[filled : filled + len(batch)] = batch
            filled += len(batch)
            progress(len(batch))
        dn.setflags(write=False)
        stacks.append(
            Frames(
                dn=dn, shot=shot, pixels=camera.pixels, bits=camera.bits, cfa=camera.cfa_of_pixels
            )
        )
    return Capture(camera=camera.name, frames=tuple(stacks), panels=tuple(panels))
