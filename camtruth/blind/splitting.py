"""A real capture in two fair halves: one to diagnose, one on which the diagnosis is held to it.

By frames: runs of frames go to either half in turn. A run keeps what frames have in common from
one to the next, and turns keep a drift from falling on one half alone. By exposures: of the shots
under one light, in the order of their brightness, every other one goes to either half.
"""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from camtruth.blind.errors import BlindError
from foundation.output import new_folder
from sensor.capture_folder import (
    CaptureDocument,
    ShotDocument,
    inside,
    read_capture,
    read_manifest,
    write_manifest,
)
from sensor.frames import Capture, Frames

HALVES = ("a", "b")
RUN_FRAMES = 8

By = Literal["frames", "exposures"]


def split(
    folder: Path, out: Path, *, by: By = "frames", run: int = RUN_FRAMES, overwrite: bool = False
) -> dict[str, dict[str, int]]:
    """Write `out/a` and `out/b`; frames of each shot in each half.

    Args:
        folder: a capture folder.
        out: where the halves go.
        by: what is divided.
        run: frames that stay together.
        overwrite: replace `out`.

    Raises:
        BlindError: when there is too little to divide.
        InputError: for a folder that is no capture.
    """
    document, capture = read_manifest(folder), read_capture(folder)
    chosen = _by_frames(capture, run) if by == "frames" else _by_exposures(capture)
    with new_folder(out, overwrite=overwrite) as made:
        for name, half in zip(HALVES, chosen, strict=True):
            (made / name).mkdir()
            _write(made / name, folder, document, capture, half)
    return {
        name: {label: len(frames) for label, frames in half.items()}
        for name, half in zip(HALVES, chosen, strict=True)
    }


Half = dict[str, NDArray[np.intp]]
"""Numbers of the frames by shot."""


def _by_frames(capture: Capture, run: int) -> tuple[Half, Half]:
    halves: tuple[Half, Half] = ({}, {})
    for frames in capture.frames:
        length = min(run, frames.count // 2)
        if length < 1:
            raise BlindError(
                f"shot '{frames.shot.label}' has one frame",
                "expected at least two to divide",
                "divide by exposures, or leave that shot out",
            )
        turns = frames.count // (2 * length)
        numbers = np.arange(turns * 2 * length).reshape(turns, 2, length)
        for k in (0, 1):
            halves[k][frames.shot.label] = numbers[:, k].ravel()
    return halves


def _by_exposures(capture: Capture) -> tuple[Half, Half]:
    ladders: dict[tuple[str, ...], list[Frames]] = {}
    for frames in capture.frames:
        ladders.setdefault(frames.shot.light if not frames.shot.dark else (), []).append(frames)
    halves: tuple[Half, Half] = ({}, {})
    for light, ladder in ladders.items():
        if len(ladder) < 2:
            raise BlindError(
                f"one shot under {' and '.join(light) or 'no light'}",
                "expected at least two exposures or levels of each light",
                "divide by frames",
            )
        ordered = sorted(ladder, key=lambda f: f.shot.exposure_s * (sum(f.shot.level) or 1.0))
        for k, frames in enumerate(ordered):
            halves[k % 2][frames.shot.label] = np.arange(frames.count)
    return halves


def _write(
    made: Path, folder: Path, document: CaptureDocument, capture: Capture, half: Half
) -> None:
    entries: list[ShotDocument] = []
    for entry, frames in zip(document.shot, capture.frames, strict=True):
        if entry.label not in half:
            continue
        file = f"{entry.label}.npy"
        numbers = half[entry.label]
        stack = np.lib.format.open_memmap(
            made / file,
            mode="w+",
            dtype=frames.dn.dtype,
            shape=(len(numbers), *frames.dn.shape[1:]),
        )
        for at, number in enumerate(numbers):
            stack[at] = frames.dn[number]
        stack.flush()
        rate = None
        if entry.rate is not None:
            rate = f"rate-{'-'.join(entry.light)}.exr"
            if not (made / rate).exists():
                shutil.copyfile(inside(folder, entry.rate), made / rate)
        entries.append(dataclasses.replace(entry, frames=file, rate=rate))
    write_manifest(made, dataclasses.replace(document, shot=tuple(entries)))
