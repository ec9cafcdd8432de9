"""What a format is: how it is written, who reads it, and which pixels it can hold."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.source import Source
from foundation.cores import in_order
from foundation.errors import unknown
from sensor.frames import Frames, Pixels

BATCH_BYTES = 16 * 640 * 480 * 3
"""Frames are read, and stacks written, in pieces of about this size: 16 of the paper's frames."""


@dataclass(frozen=True, kw_only=True)
class FrameFile:
    """A file and the frames in it: `count` of a shot from frame `first` on.

    `kept` where it stood there already, from a run that was stopped.
    """

    name: str
    shot: str
    first: int
    count: int
    kept: bool = False


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format for frames.

    Attributes:
        name: what `--format` calls it.
        says: one line on it.
        media_type: for the dataset card.
        reading: how to read a file of it with a program that is not ours, in Python.
        pixels: kinds of pixel that it holds.
        write: writes below a folder what does not stand there yet, and tells each file when it is
            done; see `once`.
        stack: where the frames of a shot lie, as a manifest names them.
        native: whether a capture folder may hold such files, or they must be imported first.
    """

    name: str
    says: str
    media_type: str
    reading: str
    pixels: tuple[Pixels, ...]
    write: Callable[[Path, Source], Iterator[FrameFile]]
    stack: str | None = None
    native: bool = False

    def refuse_pixels(self, source: Source) -> None:
        """Refuse a capture whose pixels it cannot hold.

        Raises:
            ExchangeError: with what it can hold.
        """
        found = source.document.pixels
        if found not in self.pixels:
            raise ExchangeError(
                f"a capture of {found} pixels for format '{self.name}'",
                f"expected {' or '.join(self.pixels)}",
                "choose another --format, or a camera that gives such pixels",
            )


EVERY_KIND: tuple[Pixels, ...] = ("rgb8", "bayer8", "bayer16", "mono8", "mono16")


@functools.cache
def formats() -> dict[str, Format]:
    """Every format by name, found by being a file in camtruth/exchange/formats/."""
    import camtruth.exchange.formats as folder

    modules = [
        importlib.import_module(f"{folder.__name__}.{found.name}")
        for found in pkgutil.iter_modules(folder.__path__)
    ]
    return {module.FORMAT.name: module.FORMAT for module in modules}


def format_named(name: str) -> Format:
    """The format of a name.

    Raises:
        ExchangeError: when there is none.
    """
    if name not in formats():
        raise unknown("format", name, formats(), ExchangeError)
    return formats()[name]


def shot_by_shot(
    write: Callable[[Path, Source, Frames], Iterator[FrameFile]],
) -> Callable[[Path, Source], Iterator[FrameFile]]:
    """A writer of whole captures from one that writes a shot."""

    def every(folder: Path, source: Source) -> Iterator[FrameFile]:
        for frames in source.capture.frames:
            yield from write(folder, source, frames)

    return every


def once(path: Path, make: Callable[[Path], object]) -> bool:
    """Make a file or folder whole or not at all, unless it stands there; True where it did.

    It is made under a name that begins with a dot: what a killed run leaves of it is swept away.
    """
    if path.exists():
        return True
    beside = path.with_name(f".{path.name}")
    make(beside)
    beside.replace(path)
    return False


def frame_name(label: str, index: int, ending: str) -> str:
    """The file of one frame: a folder for each shot, names that sort in the order of frames."""
    return f"{label}/{index:07d}.{ending}"


def pieces(frames: Frames) -> Iterator[tuple[int, NDArray[Any]]]:
    """The frames of a shot in pieces that fit in memory: index of the first, and the frames."""
    size = max(1, BATCH_BYTES // max(1, frames.dn[0].nbytes))
    for first in range(0, frames.count, size):
        yield first, np.ascontiguousarray(frames.dn[first : first + size])


def one_file_a_shot(
    ending: str, save: Callable[[Path, Source, Frames], None]
) -> Callable[[Path, Source], Iterator[FrameFile]]:
    """A writer of captures from one that saves a shot, piece by piece: see `pieces`."""

    def write(folder: Path, source: Source, frames: Frames) -> Iterator[FrameFile]:
        name = f"{frames.shot.label}.{ending}"
        kept = once(folder / name, lambda path: save(path, source, frames))
        yield FrameFile(name=name, shot=frames.shot.label, first=0, count=frames.count, kept=kept)

    return shot_by_shot(write)


def one_file_a_frame(
    ending: str,
    save: Callable[[Path, Source, Frames, NDArray[Any]], None],
    *,
    packed: bool,
) -> Callable[[Path, Source], Iterator[FrameFile]]:
    """A writer of captures from one that saves a frame.

    Frames that are packed are packed on all cores; the others are no work but for the disk.
    """

    def write(folder: Path, source: Source, frames: Frames) -> Iterator[FrameFile]:
        (folder / frames.shot.label).mkdir(parents=True, exist_ok=True)

        def make(index: int) -> FrameFile:
            name = frame_name(frames.shot.label, index, ending)

            def make_it(path: Path) -> None:
                save(path, source, frames, np.ascontiguousarray(frames.dn[index]))

            kept = once(folder / name, make_it)
            return FrameFile(name=name, shot=frames.shot.label, first=index, count=1, kept=kept)

        yield from (in_order if packed else map)(make, range(frames.count))

    return shot_by_shot(write)
